#include "session/history.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "session/camera_control.h"

namespace glowworm {

namespace {

/// Two points are on one surface if one lies no further from the other's plane than this share of its distance, and the
/// cosine between their normals is at least this.
constexpr float kPlaneTolerance = 0.01f;
constexpr float kNormalCosine = 0.9f;

}  // namespace

History::Found History::look_up(Vec3 position, Vec3 normal, bool hit) const {
  const Projection at = project(last_.camera, position, last_.width, last_.height);
  Found found;
  if (!(at.depth > 0) || !std::isfinite(at.film.x) || !std::isfinite(at.film.y)) return found;
  const float x = at.film.x - 0.5f, y = at.film.y - 0.5f;
  if (!(x > -1 && y > -1 && x < static_cast<float>(last_.width) && y < static_cast<float>(last_.height))) return found;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  float sum = 0;
  for (int tap = 0; tap < 4; ++tap) {
    const int tx = x0 + (tap & 1), ty = y0 + (tap >> 1);
    if (tx < 0 || ty < 0 || tx >= last_.width || ty >= last_.height) continue;
    const std::size_t i =
        static_cast<std::size_t>(ty) * static_cast<std::size_t>(last_.width) + static_cast<std::size_t>(tx);
    if (std::isfinite(last_.depth[i]) != hit) continue;
    if (hit && (dot(last_.normal[i], normal) < kNormalCosine ||
                std::abs(dot(last_.position[i] - position, normal)) > kPlaneTolerance * at.depth))
      continue;
    const float w = ((tap & 1) ? fx : 1 - fx) * ((tap >> 1) ? fy : 1 - fy);
    found.light += last_.light[i] * w;
    found.weight += weight_[i] * w;
    sum += w;
  }
  // Too small a part of the pixel shows the same surface.
  if (sum < 0.1f) return {};
  found.light = found.light / sum;
  found.weight /= sum;
  return found;
}

void History::blend_with_last(ViewImage& image, float weight, double seconds, std::span<float> weights) const {
  const auto kept = static_cast<float>(std::pow(kRest, std::max(seconds, 0.0) / kLifetime));
  parallel_for_each(image.size(), 4096, [&](std::size_t i) {
    const Found found = look_up(image.position[i], image.normal[i], std::isfinite(image.depth[i]));
    if (found.weight <= 0) return;
    // The mean over all frames, but the old share is limited by its age.
    const float old = std::min(found.weight / (found.weight + weight), kept);
    image.light[i] = lerp(image.light[i], found.light, old);
    if (!weights.empty()) weights[i] = weight / (1 - old);
  });
}

void History::blend(ViewImage& image, float weight, double seconds) {
  std::vector<float> weights(image.size(), weight);
  if (!empty()) blend_with_last(image, weight, seconds, weights);
  last_ = image;
  weight_ = std::move(weights);
}

void History::blend_resting(ViewImage& image, float weight, double seconds) const {
  if (!empty() && seconds < kLifetime) blend_with_last(image, weight, seconds, {});
}

}  // namespace glowworm
