// Vector version of the Owen-scrambled Sobol' pairs of core/random.h; compiled once for every instruction set.
#if defined(GLOWWORM_KERNELS_SOBOL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLOWWORM_KERNELS_SOBOL_INL_H_
#undef GLOWWORM_KERNELS_SOBOL_INL_H_
#else
#define GLOWWORM_KERNELS_SOBOL_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "core/random.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using SobolTag = hn::CappedTag<float, 16>;
using SobolBitsTag = hn::RebindToUnsigned<SobolTag>;
using SobolBits = hn::Vec<SobolBitsTag>;
using SobolNumbers = hn::Vec<SobolTag>;

HWY_INLINE SobolBits hash_bits(SobolBits x) {
  const SobolBitsTag u;
  x = hn::Mul(hn::Xor(x, hn::ShiftRight<16>(x)), hn::Set(u, 0x7feb352du));
  x = hn::Mul(hn::Xor(x, hn::ShiftRight<15>(x)), hn::Set(u, 0x846ca68bu));
  return hn::Xor(x, hn::ShiftRight<16>(x));
}

HWY_INLINE SobolBits combine_bits(SobolBits seed, SobolBits value) {
  const SobolBitsTag u;
  const SobolBits mixed =
      hn::Add(hn::Add(value, hn::Set(u, 0x9e3779b9u)), hn::Add(hn::ShiftLeft<6>(seed), hn::ShiftRight<2>(seed)));
  return hash_bits(hn::Xor(seed, mixed));
}

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE SobolBits reverse_bits_of(SobolBits x) {
  const SobolBitsTag u;
  return hn::Set(u, reverse_bits(hn::GetLane(x)));
}
#else
/// Reverses the bytes, then the bits of each byte by a table for its halves.
HWY_INLINE SobolBits reverse_bits_of(SobolBits x) {
  alignas(16) static constexpr std::uint8_t kBytes[16] = {3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12};
  alignas(16) static constexpr std::uint8_t kHalves[16] = {0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};
  const SobolBitsTag u;
  const hn::Repartition<std::uint8_t, SobolBitsTag> bytes;
  const auto halves = hn::LoadDup128(bytes, kHalves);
  const auto turned = hn::BitCast(u, hn::TableLookupBytes(hn::BitCast(bytes, x), hn::LoadDup128(bytes, kBytes)));
  const SobolBits low_half = hn::Set(u, 0x0f0f0f0fu);
  const auto lower = hn::TableLookupBytes(halves, hn::BitCast(bytes, hn::And(turned, low_half)));
  const auto upper = hn::TableLookupBytes(halves, hn::BitCast(bytes, hn::And(hn::ShiftRight<4>(turned), low_half)));
  return hn::Or(hn::ShiftLeft<4>(hn::BitCast(u, lower)), hn::BitCast(u, upper));
}
#endif

/// The hash of Laine and Karras for bits in reversed order.
HWY_INLINE SobolBits scramble_reversed_bits(SobolBits x, SobolBits seed) {
  const SobolBitsTag u;
  x = hn::Add(hn::Xor(x, hn::Mul(x, hn::Set(u, 0x3d20adeau))), seed);
  x = hn::Mul(x, hn::Or(hn::ShiftRight<16>(seed), hn::Set(u, 1u)));
  x = hn::Xor(x, hn::Mul(x, hn::Set(u, 0x05526c56u)));
  return hn::Xor(x, hn::Mul(x, hn::Set(u, 0x53a22864u)));
}

/// The second Sobol' dimension with its bits reversed. Its matrix is Pascal's triangle mod 2: bit i is the sum of the
/// index's bits k for which C(k, i) is odd, which holds if k has all bits of i (Lucas). This sum over supersets takes
/// one step for each of the five bits of a bit number.
HWY_INLINE SobolBits reversed_second_dimension(SobolBits x) {
  const SobolBitsTag u;
  x = hn::Xor(x, hn::And(hn::ShiftRight<1>(x), hn::Set(u, 0x55555555u)));
  x = hn::Xor(x, hn::And(hn::ShiftRight<2>(x), hn::Set(u, 0x33333333u)));
  x = hn::Xor(x, hn::And(hn::ShiftRight<4>(x), hn::Set(u, 0x0f0f0f0fu)));
  x = hn::Xor(x, hn::And(hn::ShiftRight<8>(x), hn::Set(u, 0x00ff00ffu)));
  return hn::Xor(x, hn::ShiftRight<16>(x));
}

HWY_INLINE SobolNumbers unit_numbers(SobolBits x) {
  const SobolTag f;
  const hn::RebindToSigned<SobolTag> i;
  return hn::Mul(hn::ConvertTo(f, hn::BitCast(i, hn::ShiftRight<8>(x))), hn::Set(f, 0x1p-24f));
}

/// Sampler::next2() of samplers with these keys (Sampler::pair_key()) and sample numbers.
HWY_INLINE void sobol_pair(SobolBits key, SobolBits index, SobolNumbers& x, SobolNumbers& y) {
  const SobolBitsTag u;
  const SobolBits shuffled = reverse_bits_of(scramble_reversed_bits(reverse_bits_of(index), key));
  const SobolBits key_x = hash_bits(hn::Xor(key, hn::Set(u, 0x68bc21ebu)));
  const SobolBits key_y = hash_bits(hn::Xor(key, hn::Set(u, 0x02e5be93u)));
  x = unit_numbers(reverse_bits_of(scramble_reversed_bits(shuffled, key_x)));
  y = unit_numbers(reverse_bits_of(scramble_reversed_bits(reversed_second_dimension(shuffled), key_y)));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
