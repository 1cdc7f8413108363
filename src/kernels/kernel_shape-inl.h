// Vector versions of the profiles of density kernels; compiled once for every instruction set.
#if defined(GLOWWORM_KERNELS_KERNEL_SHAPE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLOWWORM_KERNELS_KERNEL_SHAPE_INL_H_
#undef GLOWWORM_KERNELS_KERNEL_SHAPE_INL_H_
#else
#define GLOWWORM_KERNELS_KERNEL_SHAPE_INL_H_
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "kernels/kernel_shape.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// kernel_profile() at u = (distance / radius)^2. Lanes with u >= 1 are undefined.
template <KernelShape shape, class D>
HWY_INLINE hn::Vec<D> kernel_profile_at(D d, hn::Vec<D> u) {
  const auto one = hn::Set(d, 1.0f);
  if constexpr (shape == KernelShape::box) return one;
  if constexpr (shape == KernelShape::cone) return hn::Sub(one, hn::Sqrt(u));
  if constexpr (shape == KernelShape::epanechnikov) return hn::Sub(one, u);
  if constexpr (shape == KernelShape::gaussian)
    // Limits the argument to the range in use.
    return hn::Exp(d, hn::Mul(hn::Min(u, one), hn::Set(d, static_cast<float>(kGaussianExponent))));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
