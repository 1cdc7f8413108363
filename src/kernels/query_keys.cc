#include "kernels/query_keys.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/query_keys.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using U = hn::RebindToUnsigned<F>;
using FloatVector = hn::Vec<F>;
using Bits = hn::Vec<U>;

/// Moves bit i of each lane to bit 2i, for kKeyLevels bits.
HWY_INLINE Bits spread(Bits v) {
  static_assert(kKeyLevels <= 8);
  const U u;
  v = hn::And(hn::Or(v, hn::ShiftLeft<4>(v)), hn::Set(u, 0x0f0fu));
  v = hn::And(hn::Or(v, hn::ShiftLeft<2>(v)), hn::Set(u, 0x3333u));
  return hn::And(hn::Or(v, hn::ShiftLeft<1>(v)), hn::Set(u, 0x5555u));
}

/// The position of square (x, y) on a Hilbert curve through 2^kKeyLevels squares along each axis (Skilling,
/// "Programming the Hilbert curve", AIP Conference Proceedings 707, 2004: the coordinates become the key's bits level
/// by level).
HWY_INLINE Bits curve(Bits x, Bits y) {
  const U u;
  const Bits zero = hn::Zero(u);
  for (std::uint32_t bit = 1u << (kKeyLevels - 1); bit > 1; bit >>= 1) {
    const Bits upper = hn::Set(u, bit), lower = hn::Set(u, bit - 1);
    x = hn::Xor(x, hn::IfThenElse(hn::TestBit(x, upper), lower, zero));
    const auto set = hn::TestBit(y, upper);
    const Bits difference = hn::And(hn::Xor(x, y), lower);
    x = hn::Xor(x, hn::IfThenElse(set, lower, difference));
    y = hn::Xor(y, hn::IfThenElse(set, zero, difference));
  }
  y = hn::Xor(y, x);
  // Bit i: the parity of the bits of y above it.
  Bits turned = hn::ShiftRight<1>(y);
  turned = hn::Xor(turned, hn::ShiftRight<1>(turned));
  turned = hn::Xor(turned, hn::ShiftRight<2>(turned));
  turned = hn::Xor(turned, hn::ShiftRight<4>(turned));
  return hn::Or(hn::ShiftLeft<1>(spread(hn::Xor(x, turned))), spread(hn::Xor(y, turned)));
}

/// The slab, curve and group bits of a vector's keys. The group is for Lambertian points.
HWY_INLINE Bits place_on_surface(const FloatVector* n, const Bits* fine) {
  const U u;
  const FloatVector of_x = hn::Abs(n[0]), of_y = hn::Abs(n[1]), of_z = hn::Abs(n[2]);
  const auto second = hn::Gt(of_y, of_x), third = hn::Gt(of_z, hn::Max(of_x, of_y));
  const auto is_z = hn::RebindMask(u, third), is_y = hn::AndNot(is_z, hn::RebindMask(u, second));
  const auto is_x = hn::Not(hn::Or(is_y, is_z));
  const FloatVector along = hn::IfThenElse(third, n[2], hn::IfThenElse(second, n[1], n[0]));
  const Bits group = hn::Add(hn::IfThenElse(is_z, hn::Set(u, 4u), hn::IfThenElseZero(is_y, hn::Set(u, 2u))),
                             hn::ShiftRight<31>(hn::BitCast(u, along)));
  const Bits depth = hn::IfThenElse(is_z, fine[2], hn::IfThenElse(is_y, fine[1], fine[0]));
  const Bits slab = hn::ShiftRight<kKeyLevels - kKeySlabBits>(depth);
  return hn::Or(hn::Or(hn::ShiftLeft<kKeyGroupShift>(group), hn::ShiftLeft<kKeyCurveBits>(slab)),
                curve(hn::IfThenElse(is_x, fine[1], fine[0]), hn::IfThenElse(is_z, fine[1], fine[2])));
}

/// Computes the keys of one vector of points.
HWY_INLINE void keys_of_vector(const KeyGrid& grid, const float* position, const float* normal,
                               const std::uint32_t* bsdf, std::uint32_t* keys) {
  const F f;
  const U u;
  const hn::RebindToSigned<F> i;
  FloatVector p[3], n[3];
  hn::LoadInterleaved3(f, position, p[0], p[1], p[2]);
  hn::LoadInterleaved3(f, normal, n[0], n[1], n[2]);
  constexpr auto kFine = static_cast<float>(1 << kKeyLevels);
  Bits cell = hn::Zero(u), fine[3];
  std::uint32_t stride = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const FloatVector place =
        hn::Mul(hn::Sub(p[axis], hn::Set(f, grid.origin[axis])), hn::Set(f, grid.cells_per_metre * kFine));
    const FloatVector last = hn::Set(f, static_cast<float>(grid.cells[axis]) * kFine - 1);
    const Bits whole = hn::BitCast(u, hn::ConvertTo(i, hn::Min(hn::Max(place, hn::Zero(f)), last)));
    cell = hn::Add(cell, hn::Mul(hn::ShiftRight<kKeyLevels>(whole), hn::Set(u, stride)));
    fine[axis] = hn::And(whole, hn::Set(u, (1u << kKeyLevels) - 1));
    stride *= grid.cells[axis];
  }
  const auto lambertian = hn::Eq(hn::LoadU(u, bsdf), hn::Set(u, 0xffffffffu));
  const Bits place = place_on_surface(n, fine);
  const Bits other =
      hn::Or(hn::And(place, hn::Set(u, (1u << kKeyGroupShift) - 1)), hn::Set(u, kNotLambertianGroup << kKeyGroupShift));
  const Bits key = hn::Or(hn::ShiftLeft<kKeyCellShift>(cell), hn::IfThenElse(lambertian, place, other));
  // Zero times infinity or NaN is NaN.
  const FloatVector sum = hn::Add(hn::Add(hn::Add(p[0], p[1]), hn::Add(p[2], n[0])), hn::Add(n[1], n[2]));
  const auto finite = hn::Eq(hn::Mul(sum, hn::Zero(f)), hn::Zero(f));
  hn::StoreU(hn::IfThenElse(hn::RebindMask(u, finite), key, hn::Set(u, kNoKey)), u, keys);
}

void keys_of(const KeyGrid& grid, const float* position, const float* normal, const std::uint32_t* bsdf, std::size_t n,
             std::uint32_t* keys) {
  constexpr std::size_t kLanes = hn::MaxLanes(F());
  std::size_t done = 0;
  for (; done + kLanes <= n; done += kLanes)
    keys_of_vector(grid, position + 3 * done, normal + 3 * done, bsdf + done, keys + done);
  if (done == n) return;
  float padded_position[3 * kLanes] = {}, padded_normal[3 * kLanes] = {};
  std::uint32_t padded_bsdf[kLanes] = {}, padded_keys[kLanes];
  std::copy(position + 3 * done, position + 3 * n, padded_position);
  std::copy(normal + 3 * done, normal + 3 * n, padded_normal);
  std::copy(bsdf + done, bsdf + n, padded_bsdf);
  keys_of_vector(grid, padded_position, padded_normal, padded_bsdf, padded_keys);
  std::copy(padded_keys, padded_keys + (n - done), keys + done);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(keys_of);
}

void query_keys(const KeyGrid& grid, const float* position, const float* normal, const std::uint32_t* bsdf,
                std::size_t n, std::uint32_t* keys) {
  HWY_DYNAMIC_DISPATCH(keys_of)(grid, position, normal, bsdf, n, keys);
}

}  // namespace glowworm
#endif  // HWY_ONCE
