// The kernels K of the density estimators, over the unit disc: names, norms and profiles. To add a shape, add an entry
// to each list and function here, to the function in kernels/kernel_shape-inl.h, and to Kernel in
// include/glowworm/density.h. Tests take all of kKernelShapes.
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <type_traits>
#include <vector>

namespace glowworm {

/// Kernels K over the unit disc, normalised to an integral of 1 (d: distance / radius).
enum class KernelShape : std::uint8_t {
  box,           ///< 1 / pi
  cone,          ///< 3 / pi (1 - d)
  epanechnikov,  ///< 2 / pi (1 - d^2)
  gaussian,      ///< exp(-d^2 / (2 s^2)) with s = 1/3, truncated at d = 1 and normalised
};

inline constexpr KernelShape kKernelShapes[] = {KernelShape::box, KernelShape::cone, KernelShape::epanechnikov,
                                                KernelShape::gaussian};

/// Names for menus, scripts, the command line and the statistics, indexed by KernelShape.
inline const std::vector<std::string>& kernel_names() {
  static const std::vector<std::string> names = {"box", "cone", "epanechnikov", "gaussian"};
  return names;
}

/// Calls work(c), where c is a std::integral_constant of the shape: one instance of the code for each shape.
template <class Work>
[[gnu::always_inline]] inline void with_kernel_shape(KernelShape shape, Work&& work) {
  switch (shape) {
    case KernelShape::box:
      return work(std::integral_constant<KernelShape, KernelShape::box>());
    case KernelShape::cone:
      return work(std::integral_constant<KernelShape, KernelShape::cone>());
    case KernelShape::epanechnikov:
      return work(std::integral_constant<KernelShape, KernelShape::epanechnikov>());
    case KernelShape::gaussian:
      return work(std::integral_constant<KernelShape, KernelShape::gaussian>());
  }
}

/// Factors that normalise the kernels' integral over the unit disc to 1.
inline constexpr double kBoxNorm = 1 / std::numbers::pi;
inline constexpr double kConeNorm = 3 / std::numbers::pi;
inline constexpr double kEpanechnikovNorm = 2 / std::numbers::pi;
/// The Gaussian is exp(kGaussianExponent d^2), so s = 1/3. Truncated at d = 1, its integral is pi / 4.5 (1 -
/// exp(-4.5)).
inline constexpr double kGaussianExponent = -4.5;
inline constexpr double kExpOfGaussianExponent = 0.011108996538242306;
inline constexpr double kGaussianNorm = 4.5 / (std::numbers::pi * (1 - kExpOfGaussianExponent));

/// The normalising factor of a shape.
constexpr double kernel_norm(KernelShape shape) {
  switch (shape) {
    case KernelShape::box:
      return kBoxNorm;
    case KernelShape::cone:
      return kConeNorm;
    case KernelShape::epanechnikov:
      return kEpanechnikovNorm;
    case KernelShape::gaussian:
      return kGaussianNorm;
  }
  return 0;
}

/// K(d) / kernel_norm(shape) for d in [0, 1]; 1 at the centre. Estimators use it inside their sums and multiply by the
/// norm afterwards.
/// @param d_squared (distance / radius)^2; only the cone needs a square root
template <class Real>
Real kernel_profile(KernelShape shape, Real d_squared) {
  switch (shape) {
    case KernelShape::box:
      return 1;
    case KernelShape::cone:
      return 1 - std::sqrt(d_squared);
    case KernelShape::epanechnikov:
      return 1 - d_squared;
    case KernelShape::gaussian:
      return std::exp(static_cast<Real>(kGaussianExponent) * d_squared);
  }
  return 0;
}

/// K(d), normalised.
template <class Real>
Real kernel(KernelShape shape, Real d_squared) {
  return static_cast<Real>(kernel_norm(shape)) * kernel_profile(shape, d_squared);
}

}  // namespace glowworm
