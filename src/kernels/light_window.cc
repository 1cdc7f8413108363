#include "kernels/light_window.h"

#include <cmath>

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

/// Similarity of the surfaces of pixels.
HWY_INLINE WindowFloats alike_at(const WindowPlanes& p, std::ptrdiff_t here, std::ptrdiff_t to,
                                 WindowFloats slope_steps) {
  using namespace light_window;
  const WindowTag f;
  const WindowFloats one = hn::Set(f, 1.0f);
  const WindowFloats difference =
      hn::Add(hn::Add(squared_step(p.normal[0] + here, to), squared_step(p.normal[1] + here, to)),
              squared_step(p.normal[2] + here, to));
  const WindowFloats facing = above_zero(hn::Sub(one, hn::Div(difference, hn::Set(f, kNormalDifference))));
  if (hn::AllFalse(f, hn::Gt(facing, hn::Zero(f)))) return hn::Zero(f);
  const WindowFloats depth = hn::LoadU(f, p.depth + here);
  const WindowFloats slope = hn::Min(hn::LoadU(f, p.slope + here), hn::LoadU(f, p.slope + here + to));
  const WindowFloats expected =
      hn::Add(hn::Add(hn::Mul(slope_steps, slope), hn::Mul(hn::Set(f, kDepthShare), depth)), hn::Set(f, kLeastDepth));
  const WindowFloats step2 = squared_step(p.depth + here, to);
  return hn::Mul(hn::Mul(facing, facing), above_zero(hn::Sub(one, hn::Div(step2, hn::Mul(expected, expected)))));
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

HWY_INLINE void add_product(WindowFloats weight, const float* values, float* sums) {
  const WindowTag f;
  hn::StoreU(hn::Add(hn::LoadU(f, sums), hn::Mul(weight, hn::LoadU(f, values))), f, sums);
}

/// 1 less the ratio of the smaller to the larger variance of pixels: 0 for pixels of equal noise.
HWY_INLINE WindowFloats noise_difference(const WindowPlanes& p, std::ptrdiff_t here, std::ptrdiff_t to) {
  const WindowTag f;
  const WindowFloats a = hn::LoadU(f, p.variance + here), b = hn::LoadU(f, p.variance + here + to);
  const WindowFloats larger = hn::Max(hn::Max(a, b), hn::Set(f, light_window::kLeastVariance));
  return hn::Sub(hn::Set(f, 1.0f), hn::Div(hn::Min(a, b), larger));
}

/// Adds pixels that lie `to` entries on to a row of the tile, as far as the pairs around them are alike.
HWY_INLINE void add_row(const WindowPlanes& p, int y, std::ptrdiff_t to, float near, const WindowPairs& pairs,
                        WindowSums& sums) {
  using namespace light_window;
  const WindowTag f;
  const WindowFloats zero = hn::Zero(f), one = hn::Set(f, 1.0f), two = hn::Set(f, 2.0f), none = hn::Set(f, kNoWeight);
  for (std::ptrdiff_t x = 0; x < kStride; x += static_cast<std::ptrdiff_t>(hn::Lanes(f))) {
    const std::ptrdiff_t around = y * kStride + x, there = y * p.stride + x + to;
    const WindowFloats own = hn::LoadU(f, pairs.alike + around + kStride + 1);
    if (hn::AllFalse(f, hn::Gt(own, zero))) continue;
    // Of n standard normal numbers the mean square is 1 with a deviation of sqrt(2 / n).
    const WindowFloats n = hn::Max(sum_around(pairs.alike + around), hn::Set(f, 1e-6f));
    const WindowFloats deviation = hn::Sqrt(hn::Div(two, hn::Max(n, one)));
    const WindowFloats excess = hn::Div(hn::Sub(hn::Div(sum_around(pairs.differ + around), n), one), deviation);
    const WindowFloats same =
        hn::Min(above_zero(hn::Div(hn::Sub(none, excess), hn::Set(f, kNoWeight - kFullWeight))), one);
    const WindowFloats differ = hn::Div(hn::LoadU(f, pairs.differ + around + kStride + 1), own);
    const WindowFloats noise = noise_difference(p, y * p.stride + x, to);
    const WindowFloats contrast = hn::Mul(differ, hn::Mul(noise, noise));
    const WindowFloats credible = hn::Min(
        above_zero(hn::Div(hn::Sub(hn::Set(f, kNoContrast), contrast), hn::Set(f, kNoContrast - kFullContrast))), one);
    // The weight must not depend on which of the two is noisier: else rare bright samples lose their light.
    const WindowFloats surface = hn::Mul(hn::Set(f, near), own);
    const WindowFloats weight = hn::Mul(hn::Mul(surface, same), credible);
    const std::size_t at = WindowSums::at(static_cast<int>(x), y);
    hn::StoreU(hn::Add(hn::LoadU(f, sums.surface + at), surface), f, sums.surface + at);
    for (int c = 0; c < 3; ++c) add_product(weight, p.light[c] + there, sums.light[c] + at);
    hn::StoreU(hn::Add(hn::LoadU(f, sums.weight + at), weight), f, sums.weight + at);
    add_product(hn::Mul(weight, weight), p.variance + there, sums.variance + at);
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
        if (pairs.some[y + 1]) add_row(planes, y, to, 1 - static_cast<float>(distance2) / kFar, pairs, sums);
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
}

void add_window(const WindowPlanes& planes, int height, WindowSums& sums) {
  HWY_DYNAMIC_DISPATCH(add)(planes, height, sums);
}

}  // namespace glowworm
#endif  // HWY_ONCE
