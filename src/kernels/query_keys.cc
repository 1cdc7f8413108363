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

/// Bit i of each lane to bit 3i, for kKeyLevels bits.
HWY_INLINE Bits spread(Bits v) {
  static_assert(kKeyLevels <= 8);
  const U u;
  v = hn::And(hn::Or(v, hn::ShiftLeft<8>(v)), hn::Set(u, 0x0000f00fu));
  v = hn::And(hn::Or(v, hn::ShiftLeft<4>(v)), hn::Set(u, 0x000c30c3u));
  return hn::And(hn::Or(v, hn::ShiftLeft<2>(v)), hn::Set(u, 0x00249249u));
}

/// The place of cell (x, y, z) of 2^kKeyLevels along each axis on a Hilbert curve (Skilling, "Programming the Hilbert
/// curve", AIP Conference Proceedings 707, 2004: coordinates are turned into the key's bits level by level).
HWY_INLINE Bits curve(Bits x, Bits y, Bits z) {
  const U u;
  const Bits zero = hn::Zero(u);
  for (std::uint32_t bit = 1u << (kKeyLevels - 1); bit > 1; bit >>= 1) {
    const Bits upper = hn::Set(u, bit), lower = hn::Set(u, bit - 1);
    x = hn::Xor(x, hn::IfThenElse(hn::TestBit(x, upper), lower, zero));
    const auto exchange = [&](Bits& other) HWY_ATTR {
      const auto set = hn::TestBit(other, upper);
      const Bits difference = hn::And(hn::Xor(x, other), lower);
      x = hn::Xor(x, hn::IfThenElse(set, lower, difference));
      other = hn::Xor(other, hn::IfThenElse(set, zero, difference));
    };
    exchange(y);
    exchange(z);
  }
  y = hn::Xor(y, x);
  z = hn::Xor(z, y);
  Bits turned = zero;
  for (std::uint32_t bit = 1u << (kKeyLevels - 1); bit > 1; bit >>= 1)
    turned = hn::Xor(turned, hn::IfThenElse(hn::TestBit(z, hn::Set(u, bit)), hn::Set(u, bit - 1), zero));
  return hn::Or(hn::ShiftLeft<2>(spread(hn::Xor(x, turned))),
                hn::Or(hn::ShiftLeft<1>(spread(hn::Xor(y, turned))), spread(hn::Xor(z, turned))));
}

/// Which axis the normals are nearest to, and which way they point along it.
HWY_INLINE Bits direction(FloatVector x, FloatVector y, FloatVector z) {
  const U u;
  const FloatVector of_x = hn::Abs(x), of_y = hn::Abs(y), of_z = hn::Abs(z);
  const auto second = hn::Gt(of_y, of_x), third = hn::Gt(of_z, hn::Max(of_x, of_y));
  const FloatVector along = hn::IfThenElse(third, z, hn::IfThenElse(second, y, x));
  const Bits axis = hn::IfThenElse(hn::RebindMask(u, third), hn::Set(u, 4u),
                                   hn::IfThenElseZero(hn::RebindMask(u, second), hn::Set(u, 2u)));
  return hn::Add(axis, hn::ShiftRight<31>(hn::BitCast(u, along)));
}

/// The keys of as many points as a vector has lanes.
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
  const Bits group = hn::IfThenElse(lambertian, direction(n[0], n[1], n[2]), hn::Set(u, kNotLambertianGroup));
  const Bits key = hn::Or(hn::ShiftLeft<kKeyCellShift>(cell),
                          hn::Or(hn::ShiftLeft<kKeyCurveBits>(group), curve(fine[0], fine[1], fine[2])));
  // Zero times what is not finite is not a number.
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
