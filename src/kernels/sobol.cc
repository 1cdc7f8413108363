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

void pairs(std::uint32_t key, const std::uint32_t* index, std::size_t n, float* x, float* y) {
  const SobolTag f;
  const SobolBitsTag u;
  constexpr std::size_t kLanes = hn::MaxLanes(SobolTag());
  const SobolBits keys = hn::Set(u, key);
  SobolNumbers of_x, of_y;
  std::size_t done = 0;
  for (; done + kLanes <= n; done += kLanes) {
    sobol_pair(keys, hn::LoadU(u, index + done), of_x, of_y);
    hn::StoreU(of_x, f, x + done);
    hn::StoreU(of_y, f, y + done);
  }
  if (done == n) return;
  std::uint32_t rest[kLanes] = {};
  float rest_x[kLanes], rest_y[kLanes];
  for (std::size_t i = done; i < n; ++i) rest[i - done] = index[i];
  sobol_pair(keys, hn::LoadU(u, rest), of_x, of_y);
  hn::StoreU(of_x, f, rest_x);
  hn::StoreU(of_y, f, rest_y);
  for (std::size_t i = done; i < n; ++i) {
    x[i] = rest_x[i - done];
    y[i] = rest_y[i - done];
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(pairs);
}

void sobol_pairs(std::uint32_t key, const std::uint32_t* index, std::size_t n, float* x, float* y) {
  HWY_DYNAMIC_DISPATCH(pairs)(key, index, n, x, y);
}

}  // namespace glowworm
#endif  // HWY_ONCE
