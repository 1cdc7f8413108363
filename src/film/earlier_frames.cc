#include "film/earlier_frames.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "kernels/light_window.h"
#include "scene/projection.h"

namespace glowworm {

namespace {

/// Most of the expected squares of differences that the same light shows.
constexpr float kMostOfPatch = 2, kMostOfSum = 4;

/// Pixels of a view.
class Pixels {
 public:
  Pixels(const FrameView& view, const FilterGuides& guides) : view_(view), guides_(guides) {}

  bool has(int x, int y) const { return x >= 0 && y >= 0 && x < guides_.width && y < guides_.height; }
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(guides_.width) + static_cast<std::size_t>(x);
  }
  float depth(int x, int y) const { return guides_.depth[at(x, y)]; }
  Vec3 normal(int x, int y) const { return guides_.normal[at(x, y)]; }
  /// The place that the middle of a pixel shows.
  Vec3 place(int x, int y) const {
    const Vec2 film{static_cast<float>(x + view_.bounds.x0) + 0.5f, static_cast<float>(y + view_.bounds.y0) + 0.5f};
    return unproject(view_.camera, film, view_.width, view_.height, depth(x, y));
  }
  /// Change of depth to the next pixels, metres: at edges, which have short mean normals, the largest; elsewhere that
  /// on the flatter side.
  float slope(int x, int y) const {
    const bool edge = length_squared(normal(x, y)) < 0.95f;
    float slope = 0;
    for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{0, 1}}) {
      float sides[2];
      for (int side = 0; side < 2; ++side) {
        const int u = x + (side ? dx : -dx), v = y + (side ? dy : -dy);
        const float change = has(u, v) ? std::abs(depth(u, v) - depth(x, y)) : INFINITY;
        sides[side] = std::isfinite(change) ? change : edge ? 0 : INFINITY;
      }
      const float change = edge ? std::max(sides[0], sides[1]) : std::min(sides[0], sides[1]);
      if (std::isfinite(change)) slope = std::max(slope, change);
    }
    return slope;
  }
  /// The pixel that a place falls on; within the frame or not.
  Projection find(Vec3 place, int& x, int& y) const {
    const Projection found = project(view_.camera, place, view_.width, view_.height);
    const float far = 1e6f;
    const auto whole = [=](float v) { return static_cast<int>(std::floor(std::clamp(v, -far, far))); };
    x = whole(std::isfinite(found.film.x) ? found.film.x : -far) - view_.bounds.x0;
    y = whole(std::isfinite(found.film.y) ? found.film.y : -far) - view_.bounds.y0;
    return found;
  }

 private:
  const FrameView& view_;
  const FilterGuides& guides_;
};

/// Whether the light around two pixels is the same.
/// @param a with quiet_variance(). If `b` shows the same light, its samples have the same variance.
bool same_light(const LightEstimate& a, const Pixels& of_a, int x, int y, const LightEstimate& b, const Pixels& of_b,
                int u, int v) {
  float squares = 0, sum = 0, variance = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if (!of_a.has(x + dx, y + dy) || !of_b.has(u + dx, v + dy)) continue;
      const std::size_t i = of_a.at(x + dx, y + dy), j = of_b.at(u + dx, v + dy);
      const float difference = a.level[i] - b.level[j];
      squares += difference * difference;
      sum += difference;
      variance +=
          a.variance[i] * (1 + static_cast<float>(a.samples[i]) / static_cast<float>(std::max(b.samples[j], 1u)));
    }
  return squares <= kMostOfPatch * variance && sum * sum <= kMostOfSum * variance;
}

/// Variances for same_light(). At edges of light, the spread of a pixel's samples is far above the noise of their mean,
/// because they are stratified: so no variance is more than what pixels on the quieter side have.
std::vector<float> quiet_variance(const LightEstimate& estimate, const FilterGuides& guides) {
  std::vector<float> out = expected_variance(estimate, guides);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::min(out[i], estimate.variance[i]);
  return out;
}

}  // namespace

void add_earlier_samples(const EarlierFrames& earlier, const FilterGuides& guides, LightEstimate FrameLight::*layer,
                         LightEstimate& estimate) {
  LightEstimate own = estimate;
  own.variance = quiet_variance(estimate, guides);
  const Pixels pixels(earlier.view, guides);
  const auto add_to = [&](int x, int y) {
    const std::size_t i = pixels.at(x, y);
    if (!std::isfinite(pixels.depth(x, y)) || own.samples[i] == 0) return;
    const Vec3 place = pixels.place(x, y), normal = pixels.normal(x, y);
    const float slope = pixels.slope(x, y);
    float samples = static_cast<float>(own.samples[i]);
    RGB light = own.light[i] * samples;
    float level = own.level[i] * samples, variance = estimate.variance[i] * samples * samples;
    for (const std::shared_ptr<const FrameLight>& frame : earlier.frames) {
      const Pixels others(frame->view, frame->guides);
      int u = 0, v = 0;
      const Projection found = others.find(place, u, v);
      if (!(found.depth > 0) || !others.has(u, v)) continue;
      // The place may lie a hundredth of its distance beside the one found again, beside the slope of the surface.
      const bool same_place = length_squared(others.normal(u, v) - normal) <= kNormalDifference &&
                              std::abs(others.depth(u, v) - found.depth) <= 0.01f * found.depth + slope;
      const LightEstimate& other = (*frame).*layer;
      if (!same_place || !same_light(own, pixels, x, y, other, others, u, v)) continue;
      const std::size_t j = others.at(u, v);
      const auto more = static_cast<float>(other.samples[j]);
      light += other.light[j] * more;
      level += other.level[j] * more;
      variance += other.variance[j] * more * more;
      samples += more;
      estimate.samples[i] += other.samples[j];
    }
    estimate.light[i] = light / samples;
    estimate.level[i] = level / samples;
    estimate.variance[i] = variance / (samples * samples);
  };
  parallel_for_each(static_cast<std::size_t>(guides.height), 4, [&](std::size_t y) {
    for (int x = 0; x < guides.width; ++x) add_to(x, static_cast<int>(y));
  });
}

}  // namespace glowworm
