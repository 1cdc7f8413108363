#include "session/preview_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"

namespace glowworm {

namespace {

/// Light is divided by albedo, which is at least this, so that textures are not smoothed.
constexpr float kMinAlbedo = 0.02f;
/// Differences at which a neighbour counts half.
constexpr float kAlbedoScale = 0.1f;   // of albedo
constexpr float kPlaneScale = 0.004f;  // of the distance to the plane, as a share of depth
constexpr float kLightScale = 0.35f;   // of compressed luminance, at the first pass; halved from pass to pass

RGB shading_albedo(RGB albedo) {
  return {std::max(albedo.r, kMinAlbedo), std::max(albedo.g, kMinAlbedo), std::max(albedo.b, kMinAlbedo)};
}

float squared(float x) { return x * x; }

/// Luminance in [0, 1), compressed roughly as the eye perceives bright values.
float compressed(RGB light) {
  const float l = std::max(luminance(light), 0.0f);
  return l / (1 + l);
}

/// cos^32 of the angle between two normals; 1 if both are zero.
float normal_weight(Vec3 a, Vec3 b) {
  float c = a == b ? 1.0f : std::max(dot(a, b), 0.0f);
  for (int i = 0; i < 5; ++i) c *= c;
  return c;
}

class WaveletPass {
 public:
  WaveletPass(const ViewImage& guide, const std::vector<RGB>& from, int step, float light_scale)
      : guide_(guide), from_(from), step_(step), light_scale_(light_scale) {}

  RGB filtered(int x, int y) const {
    const std::size_t center = index(x, y);
    if (!std::isfinite(guide_.depth[center])) return from_[center];
    const float level = compressed(from_[center]);
    RGB sum = from_[center] * 4;
    float weights = 4;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int nx = x + dx * step_, ny = y + dy * step_;
        if ((dx == 0 && dy == 0) || nx < 0 || ny < 0 || nx >= guide_.width || ny >= guide_.height) continue;
        const std::size_t other = index(nx, ny);
        // The binomial kernel 1 2 1 in both directions.
        const float w = (dx == 0 || dy == 0 ? 2.0f : 1.0f) * weight(center, other, level);
        sum += from_[other] * w;
        weights += w;
      }
    return sum / weights;
  }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(guide_.width) + static_cast<std::size_t>(x);
  }

  float weight(std::size_t center, std::size_t other, float level) const {
    if (!std::isfinite(guide_.depth[other])) return 0;
    const float alike = normal_weight(guide_.normal[center], guide_.normal[other]);
    if (alike < 1e-3f) return 0;
    const RGB albedo = guide_.albedo[center] - guide_.albedo[other];
    const float plane = dot(guide_.position[other] - guide_.position[center], guide_.normal[center]) /
                        (kPlaneScale * guide_.depth[center]);
    const float light = (compressed(from_[other]) - level) / light_scale_;
    const float far_apart = (squared(albedo.r) + squared(albedo.g) + squared(albedo.b)) / squared(kAlbedoScale);
    return alike / ((1 + far_apart) * (1 + squared(plane)) * (1 + squared(light)));
  }

  const ViewImage& guide_;
  const std::vector<RGB>& from_;
  int step_;
  float light_scale_;
};

}  // namespace

void filter_preview(ViewImage& image, int passes) {
  std::vector<RGB> from(image.size()), to(image.size());
  for (std::size_t i = 0; i < from.size(); ++i) from[i] = image.light[i] / shading_albedo(image.albedo[i]);
  float light_scale = kLightScale;
  for (int pass = 0; pass < passes; ++pass, light_scale /= 2) {
    const WaveletPass wavelet(image, from, 1 << pass, light_scale);
    parallel_for_each(static_cast<std::size_t>(image.height), 8, [&](std::size_t y) {
      for (int x = 0; x < image.width; ++x)
        to[y * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)] =
            wavelet.filtered(x, static_cast<int>(y));
    });
    std::swap(from, to);
  }
  for (std::size_t i = 0; i < from.size(); ++i) image.light[i] = from[i] * shading_albedo(image.albedo[i]);
}

}  // namespace glowworm
