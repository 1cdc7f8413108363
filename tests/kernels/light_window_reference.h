#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/light_window.h"

namespace glowworm {

namespace light_window {

/// Similarity of a pixel and the one `to` entries on, and its product with the squared normalized difference.
struct Pair {
  float alike, differ;
};

inline float square(float x) { return x * x; }

/// Squared steps from a pixel to the one `to` entries on: of normals, of depth, and what the slope explains of it.
struct SurfaceSteps {
  float normal, depth, slope;
};

inline SurfaceSteps surface_steps(const WindowPlanes& planes, std::ptrdiff_t here, std::ptrdiff_t to, float distance) {
  const std::ptrdiff_t there = here + to;
  return {square(planes.normal[0][there] - planes.normal[0][here]) +
              square(planes.normal[1][there] - planes.normal[1][here]) +
              square(planes.normal[2][there] - planes.normal[2][here]),
          square(planes.depth[there] - planes.depth[here]),
          square(1.5f * distance * std::min(planes.slope[here], planes.slope[there]) +
                 kDepthShare * planes.depth[here] + kLeastDepth)};
}

inline Pair compare(const WindowPlanes& planes, std::ptrdiff_t here, std::ptrdiff_t to, float distance) {
  const std::ptrdiff_t there = here + to;
  const SurfaceSteps steps = surface_steps(planes, here, to, distance);
  // In this order NaN gives 0.
  const float facing = std::max(0.0f, 1 - steps.normal / kNormalDifference);
  const float alike = facing * facing * std::max(0.0f, 1 - steps.depth / steps.slope);
  const float d = planes.level[there] - planes.level[here];
  const float least = kMinVariance * planes.level[here] * planes.level[here] + kLeastVariance;
  return {alike, alike * d * d / (planes.variance[here] + planes.variance[there] + least)};
}

inline float same_noise(const WindowPlanes& planes, std::ptrdiff_t here, std::ptrdiff_t to) {
  const float least = kLeastNoise * square(std::min(planes.shown[here], planes.shown[here + to])) + kLeastVariance;
  const float a = planes.noise[here], b = planes.noise[here + to];
  const float share = std::min((std::min(a, b) + least) / (std::max(a, b) + least) / kSameNoise, 1.0f);
  return share * (share * share);
}

inline void add_pixel(const WindowPlanes& planes, std::ptrdiff_t here, float step_x, float step_y, WindowSums& sums,
                      std::size_t at) {
  const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(step_y) * planes.stride + static_cast<std::ptrdiff_t>(step_x);
  const float distance2 = step_x * step_x + step_y * step_y, distance = std::sqrt(distance2);
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
  // The weight must not depend on which of the two is noisier: else rare bright samples lose their light.
  const float surface = near * own.alike, any = surface * same_noise(planes, here, to), weight = any * same;
  for (int c = 0; c < 3; ++c) sums.light[c][at] += weight * planes.light[c][here + to];
  sums.weight[at] += weight;
  sums.surface[at] += surface;
  sums.variance[at] += weight * weight * planes.variance[here + to];
  const float level = weight * planes.level[here + to], step[] = {step_x, step_y};
  sums.level[at] += level;
  sums.any_weight[at] += any;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    sums.step[axis][at] += weight * step[axis];
    sums.slope[axis][at] += level * step[axis];
    sums.any_step[axis][at] += any * step[axis];
  }
  sums.square[0][at] += weight * step_x * step_x;
  sums.square[1][at] += weight * step_x * step_y;
  sums.square[2][at] += weight * step_y * step_y;
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
          light_window::add_pixel(planes, y * planes.stride + x, static_cast<float>(dx), static_cast<float>(dy), sums,
                                  WindowSums::at(x, y));
    }
}

/// find_noise() as plain loops, bit for bit.
inline void find_noise_reference(const WindowPlanes& planes, int width, float* noise) {
  using namespace light_window;
  for (int x = 0; x < width; ++x) {
    float spread[kOctants] = {}, counts[kOctants] = {}, sum = 0, count = 1, shown = 0;
    for (int i = 0; i < kOctants; ++i) {
      for (int k = 0; k < kOctantPixels; ++k) {
        const OctantStep step = octant_step(i, k);
        const std::ptrdiff_t to = step.y * planes.stride + step.x;
        const float distance = std::sqrt(static_cast<float>(step.x * step.x + step.y * step.y));
        const SurfaceSteps steps = surface_steps(planes, x, to, distance);
        if (!(steps.normal < kNormalDifference && steps.depth < steps.slope)) continue;
        spread[i] += planes.spread[x + to];
        shown += planes.shown[x + to];
        counts[i] += 1;
      }
      sum += spread[i];
      count += counts[i];
    }
    const float around = shown / std::max(count - 1, 1.0f),
                most = planes.lone ? kHidden : std::numeric_limits<float>::max();
    const float hidden = most * (around * around);
    const float own = std::min(planes.spread[x], std::max(sum * kOwnShare, planes.spread[x] - hidden));
    const float mean = (sum + own) / count;
    noise[x] = std::numeric_limits<float>::infinity();
    for (int i = 0; i < kOctants; ++i) {
      const int next = (i + 1) % kOctants;
      const float there = 1 + counts[i] + counts[next], counted = std::max(there, kOctantPixels + 1.0f);
      const float of_side = own + spread[i] + spread[next];
      noise[x] = std::min(noise[x], (of_side + (counted - there) * mean) / counted);
    }
  }
}

}  // namespace glowworm
