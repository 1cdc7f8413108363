#include "kernels/sobol.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/sobol.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "kernels/sobol-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

/// Calls pair(numbers, x, y) for vectors of `in`, and writes x and y.
template <typename Pair>
HWY_INLINE void for_each_vector(const std::uint32_t* in, std::size_t n, float* x, float* y, const Pair& pair) {
  const SobolTag f;
  const SobolBitsTag u;
  constexpr std::size_t kLanes = hn::MaxLanes(SobolTag());
  SobolNumbers of_x, of_y;
  std::size_t done = 0;
  for (; done + kLanes <= n; done += kLanes) {
    pair(hn::LoadU(u, in + done), of_x, of_y);
    hn::StoreU(of_x, f, x + done);
    hn::StoreU(of_y, f, y + done);
  }
  if (done == n) return;
  std::uint32_t rest[kLanes] = {};
  float rest_x[kLanes], rest_y[kLanes];
  for (std::size_t i = done; i < n; ++i) rest[i - done] = in[i];
  pair(hn::LoadU(u, rest), of_x, of_y);
  hn::StoreU(of_x, f, rest_x);
  hn::StoreU(of_y, f, rest_y);
  for (std::size_t i = done; i < n; ++i) {
    x[i] = rest_x[i - done];
    y[i] = rest_y[i - done];
  }
}

void pairs(std::uint32_t key, const std::uint32_t* index, std::size_t n, float* x, float* y) {
  const SobolBits keys = hn::Set(SobolBitsTag(), key);
  for_each_vector(index, n, x, y, [&](SobolBits indices, SobolNumbers& of_x, SobolNumbers& of_y) HWY_ATTR {
    sobol_pair(keys, indices, of_x, of_y);
  });
}

void pairs_of(std::uint32_t seed, const std::uint32_t* sequence, std::size_t n, std::uint32_t index,
              std::uint32_t dimension, float* x, float* y) {
  const SobolBitsTag u;
  const SobolBits seed_key = hn::Set(u, Sampler::seed_key(seed)), dimensions = hn::Set(u, dimension);
  const SobolBits indices = hn::Set(u, index);
  for_each_vector(sequence, n, x, y, [&](SobolBits sequences, SobolNumbers& of_x, SobolNumbers& of_y) HWY_ATTR {
    sobol_pair(combine_bits(combine_bits(seed_key, sequences), dimensions), indices, of_x, of_y);
  });
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(pairs);
HWY_EXPORT(pairs_of);
}  // namespace

void sobol_pairs(std::uint32_t key, const std::uint32_t* index, std::size_t n, float* x, float* y) {
  HWY_DYNAMIC_DISPATCH(pairs)(key, index, n, x, y);
}

void sobol_pairs_of(std::uint32_t seed, const std::uint32_t* sequence, std::size_t n, std::uint32_t index,
                    std::uint32_t dimension, float* x, float* y) {
  HWY_DYNAMIC_DISPATCH(pairs_of)(seed, sequence, n, index, dimension, x, y);
}

}  // namespace glowworm
#endif  // HWY_ONCE
