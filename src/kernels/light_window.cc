#include "kernels/light_window.h"

#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_window.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using WindowTag = hn::CappedTag<float, kWindowPadding>;
using WindowFloats = hn::Vec<WindowTag>;

constexpr std::ptrdiff_t kStride = WindowSums::kStride;
constexpr int kPairRows = WindowSums::kHeight + 2;

/// Pairs of pixels `to` entries apart, for a tile with a border of one pixel.
struct WindowPairs {
  float alike[kStride * kPairRows + kWindowPadding];   ///< similarity of the surfaces
  float differ[kStride * kPairRows + kWindowPadding];  ///< squared normalized difference of levels, times similarity
  bool some[kPairRows];                                ///< rows with a pair that is alike
};

HWY_INLINE WindowFloats squared_step(const float* plane, std::ptrdiff_t to) {
  const WindowTag f;
  const WindowFloats step = hn::Sub(hn::LoadU(f, plane + to), hn::LoadU(f, plane));
  return hn::Mul(step, step);
}

/// The larger of a number and 0; of NaN, 0.
HWY_INLINE WindowFloats above_zero(WindowFloats x) { return hn::IfThenElseZero(hn::Gt(x, hn::Zero(WindowTag())), x); }

/// Squared distance of the normals of two pixels.
HWY_INLINE WindowFloats normal_step(const WindowPlanes& p, std::ptrdiff_t here, std::ptrdiff_t to) {
  return hn::Add(hn::Add(squared_step(p.normal[0] + here, to), squared_step(p.normal[1] + here, to)),
                 squared_step(p.normal[2] + here, to));
}

/// Square of the difference of depth that the slope of a surface explains.
HWY_INLINE WindowFloats squared_slope(const WindowPlanes& p, std::ptrdiff_t here, std::ptrdiff_t to,
                                      WindowFloats slope_steps) {
  using namespace light_window;
  const WindowTag f;
  const WindowFloats slope = hn::Min(hn::LoadU(f, p.slope + here), hn::LoadU(f, p.slope + here + to));
  const WindowFloats share = hn::Mul(hn::Set(f, kDepthShare), hn::LoadU(f, p.depth + here));
  const WindowFloats expected = hn::Add(hn::Add(hn::Mul(slope_steps, slope), share), hn::Set(f, kLeastDepth));
  return hn::Mul(expected, expected);
}

/// Similarity of the surfaces of pixels.
HWY_INLINE WindowFloats alike_at(const WindowPlanes& p, std::ptrdiff_t here, std::ptrdiff_t to,
                                 WindowFloats slope_steps) {
  const WindowTag f;
  const WindowFloats one = hn::Set(f, 1.0f);
  const WindowFloats difference = hn::Div(normal_step(p, here, to), hn::Set(f, kNormalDifference));
  const WindowFloats facing = above_zero(hn::Sub(one, difference));
  if (hn::AllFalse(f, hn::Gt(facing, hn::Zero(f)))) return hn::Zero(f);
  const WindowFloats step2 = squared_step(p.depth + here, to);
  return hn::Mul(hn::Mul(facing, facing),
                 above_zero(hn::Sub(one, hn::Div(step2, squared_slope(p, here, to, slope_steps)))));
}

/// Compares each pixel of a row of the tile, with one pixel on both sides, with the one that lies `to` entries on.
HWY_INLINE bool compare_row(const WindowPlanes& p, std::ptrdiff_t row, std::ptrdiff_t to, float distance, float* alike,
                            float* differ) {
  using namespace light_window;
  const WindowTag f;
  const WindowFloats zero = hn::Zero(f), slope_steps = hn::Set(f, 1.5f * distance);
  bool some = false;
  for (std::ptrdiff_t x = 0; x < kStride; x += static_cast<std::ptrdiff_t>(hn::Lanes(f))) {
    const std::ptrdiff_t here = row + x - 1;
    const WindowFloats a = alike_at(p, here, to, slope_steps);
    hn::StoreU(a, f, alike + x);
    if (hn::AllFalse(f, hn::Gt(a, zero))) {
      hn::StoreU(zero, f, differ + x);
      continue;
    }
    some = true;
    const WindowFloats level = hn::LoadU(f, p.level + here);
    const WindowFloats d = hn::Sub(hn::LoadU(f, p.level + here + to), level);
    const WindowFloats least =
        hn::Add(hn::Mul(hn::Mul(hn::Set(f, kMinVariance), level), level), hn::Set(f, kLeastVariance));
    const WindowFloats variance =
        hn::Add(hn::Add(hn::LoadU(f, p.variance + here), hn::LoadU(f, p.variance + here + to)), least);
    hn::StoreU(hn::Div(hn::Mul(hn::Mul(a, d), d), variance), f, differ + x);
  }
  return some;
}

/// Sum over the pixels around each of a row, in rows of pairs.
HWY_INLINE WindowFloats sum_around(const float* pairs) {
  const WindowTag f;
  WindowFloats sum = hn::LoadU(f, pairs);
  for (std::ptrdiff_t i = 1; i < 9; ++i) sum = hn::Add(sum, hn::LoadU(f, pairs + i / 3 * kStride + i % 3));
  return sum;
}

/// Adds to sums of a row.
HWY_INLINE void add_to(float* sums, WindowFloats values) {
  const WindowTag f;
  hn::StoreU(hn::Add(hn::LoadU(f, sums), values), f, sums);
}

/// How far the noise of pixels is the same.
HWY_INLINE WindowFloats same_noise(const WindowPlanes& p, std::ptrdiff_t here, std::ptrdiff_t to) {
  using namespace light_window;
  const WindowTag f;
  const WindowFloats shown = hn::Min(hn::LoadU(f, p.shown + here), hn::LoadU(f, p.shown + here + to));
  const WindowFloats least =
      hn::Add(hn::Mul(hn::Set(f, kLeastNoise), hn::Mul(shown, shown)), hn::Set(f, kLeastVariance));
  const WindowFloats a = hn::LoadU(f, p.noise + here), b = hn::LoadU(f, p.noise + here + to);
  const WindowFloats ratio = hn::Div(hn::Add(hn::Min(a, b), least), hn::Add(hn::Max(a, b), least));
  const WindowFloats share = hn::Min(hn::Div(ratio, hn::Set(f, kSameNoise)), hn::Set(f, 1.0f));
  return hn::Mul(share, hn::Mul(share, share));
}

/// What all pairs of a step have in common.
struct WindowStep {
  int x, y;
  std::ptrdiff_t to;  ///< entries
  float near;         ///< weight by distance
};

/// Adds a row of the pixels that lie a step away to the sums at `at`.
/// @param any weights by surface and noise; @param same how far the light is the same
HWY_INLINE void add_pixels(const WindowPlanes& p, std::ptrdiff_t there, const WindowStep& step, WindowFloats any,
                           WindowFloats same, std::size_t at, WindowSums& sums) {
  const WindowTag f;
  const WindowFloats x = hn::Set(f, static_cast<float>(step.x)), y = hn::Set(f, static_cast<float>(step.y));
  const WindowFloats weight = hn::Mul(any, same), level = hn::Mul(weight, hn::LoadU(f, p.level + there));
  const WindowFloats weight_x = hn::Mul(weight, x), weight_y = hn::Mul(weight, y);
  for (int c = 0; c < 3; ++c) add_to(sums.light[c] + at, hn::Mul(weight, hn::LoadU(f, p.light[c] + there)));
  add_to(sums.weight + at, weight);
  add_to(sums.variance + at, hn::Mul(hn::Mul(weight, weight), hn::LoadU(f, p.variance + there)));
  add_to(sums.level + at, level);
  add_to(sums.step[0] + at, weight_x);
  add_to(sums.step[1] + at, weight_y);
  add_to(sums.square[0] + at, hn::Mul(weight_x, x));
  add_to(sums.square[1] + at, hn::Mul(weight_x, y));
  add_to(sums.square[2] + at, hn::Mul(weight_y, y));
  add_to(sums.slope[0] + at, hn::Mul(level, x));
  add_to(sums.slope[1] + at, hn::Mul(level, y));
  add_to(sums.any_weight + at, any);
  add_to(sums.any_step[0] + at, hn::Mul(any, x));
  add_to(sums.any_step[1] + at, hn::Mul(any, y));
}

/// Adds pixels that lie a step away to a row of the tile, as far as the pairs around them are alike.
HWY_INLINE void add_row(const WindowPlanes& p, int row, const WindowStep& step, const WindowPairs& pairs,
                        WindowSums& sums) {
  using namespace light_window;
  const WindowTag f;
  const WindowFloats zero = hn::Zero(f), one = hn::Set(f, 1.0f), two = hn::Set(f, 2.0f), none = hn::Set(f, kNoWeight);
  for (std::ptrdiff_t x = 0; x < kStride; x += static_cast<std::ptrdiff_t>(hn::Lanes(f))) {
    const std::ptrdiff_t around = row * kStride + x, here = row * p.stride + x;
    const WindowFloats own = hn::LoadU(f, pairs.alike + around + kStride + 1);
    if (hn::AllFalse(f, hn::Gt(own, zero))) continue;
    // Of n standard normal numbers the mean square is 1 with a deviation of sqrt(2 / n).
    const WindowFloats n = hn::Max(sum_around(pairs.alike + around), hn::Set(f, 1e-6f));
    const WindowFloats deviation = hn::Sqrt(hn::Div(two, hn::Max(n, one)));
    const WindowFloats excess = hn::Div(hn::Sub(hn::Div(sum_around(pairs.differ + around), n), one), deviation);
    const WindowFloats same =
        hn::Min(above_zero(hn::Div(hn::Sub(none, excess), hn::Set(f, kNoWeight - kFullWeight))), one);
    // The weight must not depend on which of the two is noisier: else rare bright samples lose their light.
    const WindowFloats surface = hn::Mul(hn::Set(f, step.near), own);
    const std::size_t at = WindowSums::at(static_cast<int>(x), row);
    add_to(sums.surface + at, surface);
    add_pixels(p, here + step.to, step, hn::Mul(surface, same_noise(p, here, step.to)), same, at, sums);
  }
}

void add(const WindowPlanes& planes, int height, WindowSums& sums) {
  WindowPairs pairs = {};
  for (int dy = -kWindowReach; dy <= kWindowReach; ++dy)
    for (int dx = -kWindowReach; dx <= kWindowReach; ++dx) {
      const int distance2 = dx * dx + dy * dy;
      if (distance2 == 0 || distance2 > kWindowReach * kWindowReach) continue;
      const std::ptrdiff_t to = dy * planes.stride + dx;
      const float distance = std::sqrt(static_cast<float>(distance2));
      for (int row = 0; row < height + 2; ++row)
        pairs.some[row] = compare_row(planes, (row - 1) * planes.stride, to, distance, pairs.alike + row * kStride,
                                      pairs.differ + row * kStride);
      constexpr float kFar = static_cast<float>((kWindowReach + 1) * (kWindowReach + 1));
      for (int y = 0; y < height; ++y)
        if (pairs.some[y + 1]) add_row(planes, y, {dx, dy, to, 1 - static_cast<float>(distance2) / kFar}, pairs, sums);
    }
}

/// The pixels of an octant that show the same surface: sums of their spread and luminance, and their number.
struct OctantSums {
  WindowFloats spread, shown, count;
};
HWY_INLINE OctantSums sum_octant(const WindowPlanes& p, std::ptrdiff_t here, int octant) {
  using namespace light_window;
  const WindowTag f;
  OctantSums out{hn::Zero(f), hn::Zero(f), hn::Zero(f)};
  for (int i = 0; i < kOctantPixels; ++i) {
    const OctantStep step = octant_step(octant, i);
    const std::ptrdiff_t to = step.y * p.stride + step.x;
    const float distance = std::sqrt(static_cast<float>(step.x * step.x + step.y * step.y));
    const auto alike =
        hn::And(hn::Lt(normal_step(p, here, to), hn::Set(f, kNormalDifference)),
                hn::Lt(squared_step(p.depth + here, to), squared_slope(p, here, to, hn::Set(f, 1.5f * distance))));
    out.spread = hn::Add(out.spread, hn::IfThenElseZero(alike, hn::LoadU(f, p.spread + here + to)));
    out.shown = hn::Add(out.shown, hn::IfThenElseZero(alike, hn::LoadU(f, p.shown + here + to)));
    out.count = hn::Add(out.count, hn::IfThenElseZero(alike, hn::Set(f, 1.0f)));
  }
  return out;
}

void noise_of_row(const WindowPlanes& p, int width, float* noise) {
  using namespace light_window;
  const WindowTag f;
  float spread[kOctants * kWindowPadding], count[kOctants * kWindowPadding];  // without the pixel itself
  const WindowFloats most = hn::Set(f, p.lone ? kHidden : std::numeric_limits<float>::max());
  for (std::ptrdiff_t x = 0; x < width; x += static_cast<std::ptrdiff_t>(hn::Lanes(f))) {
    const WindowFloats one = hn::Set(f, 1.0f), enough = hn::Set(f, kOctantPixels + 1.0f);
    WindowFloats sum = hn::Zero(f), shown = hn::Zero(f), number = one;
    for (std::size_t i = 0; i < kOctants; ++i) {
      const OctantSums octant = sum_octant(p, x, static_cast<int>(i));
      sum = hn::Add(sum, octant.spread);
      shown = hn::Add(shown, octant.shown);
      number = hn::Add(number, octant.count);
      hn::StoreU(octant.spread, f, spread + i * kWindowPadding);
      hn::StoreU(octant.count, f, count + i * kWindowPadding);
    }
    const WindowFloats around = hn::Div(shown, hn::Max(hn::Sub(number, one), one)), all = hn::LoadU(f, p.spread + x);
    const WindowFloats hidden = hn::Mul(most, hn::Mul(around, around));
    const WindowFloats own = hn::Min(all, hn::Max(hn::Mul(sum, hn::Set(f, kOwnShare)), hn::Sub(all, hidden)));
    // Where a side has little of the surface, the mean of all stands for the rest.
    const WindowFloats mean = hn::Div(hn::Add(sum, own), number);
    WindowFloats least = hn::Set(f, std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < kOctants; ++i) {
      WindowFloats of_side = own, there = one;
      for (std::size_t k = i; k < i + kSideOctants; ++k) {
        of_side = hn::Add(of_side, hn::LoadU(f, spread + k % kOctants * kWindowPadding));
        there = hn::Add(there, hn::LoadU(f, count + k % kOctants * kWindowPadding));
      }
      const WindowFloats counted = hn::Max(there, enough), rest = hn::Sub(counted, there);
      least = hn::Min(least, hn::Div(hn::Add(of_side, hn::Mul(rest, mean)), counted));
    }
    hn::StoreU(least, f, noise + x);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(add);
HWY_EXPORT(noise_of_row);
}  // namespace

void find_noise(const WindowPlanes& planes, int width, float* noise) {
  HWY_DYNAMIC_DISPATCH(noise_of_row)(planes, width, noise);
}

void add_window(const WindowPlanes& planes, int height, WindowSums& sums) {
  HWY_DYNAMIC_DISPATCH(add)(planes, height, sums);
}

}  // namespace glowworm
#endif  // HWY_ONCE
