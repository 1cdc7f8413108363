#pragma once
#include <algorithm>
#include <cmath>

#include "kernels/light_window.h"

namespace glowworm {

namespace light_window {

/// Similarity of a pixel and the one `to` entries on, and its product with the squared normalized difference.
struct Pair {
  float alike, differ;
};

inline float square(float x) { return x * x; }

inline Pair compare(const WindowPlanes& planes, std::ptrdiff_t here, std::ptrdiff_t to, float distance) {
  const std::ptrdiff_t there = here + to;
  const float difference = square(planes.normal[0][there] - planes.normal[0][here]) +
                           square(planes.normal[1][there] - planes.normal[1][here]) +
                           square(planes.normal[2][there] - planes.normal[2][here]);
  // In this order NaN gives 0.
  const float facing = std::max(0.0f, 1 - difference / kNormalDifference);
  const float step = planes.depth[there] - planes.depth[here];
  const float expected = 1.5f * distance * std::min(planes.slope[here], planes.slope[there]) +
                         kDepthShare * planes.depth[here] + kLeastDepth;
  const float alike = facing * facing * std::max(0.0f, 1 - step * step / (expected * expected));
  const float d = planes.level[there] - planes.level[here];
  const float least = kMinVariance * planes.level[here] * planes.level[here] + kLeastVariance;
  return {alike, alike * d * d / (planes.variance[here] + planes.variance[there] + least)};
}

inline void add_pixel(const WindowPlanes& planes, std::ptrdiff_t here, std::ptrdiff_t to, float distance2,
                      WindowSums& sums, std::size_t at) {
  const float distance = std::sqrt(distance2);
  float alike = 0, differ = 0;
  for (std::ptrdiff_t y = -1; y <= 1; ++y)
    for (std::ptrdiff_t x = -1; x <= 1; ++x) {
      const Pair pair = compare(planes, here + y * planes.stride + x, to, distance);
      alike += pair.alike;
      differ += pair.differ;
    }
  // Of n standard normal numbers the mean square is 1 with a deviation of sqrt(2 / n).
  const float n = std::max(alike, 1e-6f);
  const float excess = (differ / n - 1) / std::sqrt(2 / std::max(n, 1.0f));
  const float same = std::min(std::max((kNoWeight - excess) / (kNoWeight - kFullWeight), 0.0f), 1.0f);
  const float near = 1 - distance2 / square(kWindowReach + 1);
  const Pair own = compare(planes, here, to, distance);
  if (!(own.alike > 0)) return;
  const float a = planes.variance[here], b = planes.variance[here + to];
  const float noise = 1 - std::min(a, b) / std::max({a, b, kLeastVariance});
  const float contrast = own.differ / own.alike * (noise * noise);
  const float credible = std::min(std::max((kNoContrast - contrast) / (kNoContrast - kFullContrast), 0.0f), 1.0f);
  // The weight must not depend on which of the two is noisier: else rare bright samples lose their light.
  const float surface = near * own.alike, weight = surface * same * credible;
  for (int c = 0; c < 3; ++c) sums.light[c][at] += weight * planes.light[c][here + to];
  sums.weight[at] += weight;
  sums.surface[at] += surface;
  sums.variance[at] += weight * weight * planes.variance[here + to];
}

}  // namespace light_window

/// add_window() as plain loops, bit for bit.
inline void add_window_reference(const WindowPlanes& planes, int height, WindowSums& sums) {
  for (int dy = -kWindowReach; dy <= kWindowReach; ++dy)
    for (int dx = -kWindowReach; dx <= kWindowReach; ++dx) {
      const int distance2 = dx * dx + dy * dy;
      if (distance2 == 0 || distance2 > kWindowReach * kWindowReach) continue;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < WindowSums::kWidth; ++x)
          light_window::add_pixel(planes, y * planes.stride + x, dy * planes.stride + dx, static_cast<float>(distance2),
                                  sums, WindowSums::at(x, y));
    }
}

}  // namespace glowworm
