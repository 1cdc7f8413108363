// Data of glossy query points for the kernels: arrays of the numbers of their BSDFs.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace glowworm {

/// How the numbers of a point are combined (bsdf/reflection.h describes each).
enum class GlossyModel : std::uint8_t { coated, conductor, schlick };
inline constexpr std::size_t kGlossyModels = 3;

/// Calls work(c), where c is a std::integral_constant of the model: one instance of the code for each model.
template <class Work>
[[gnu::always_inline]] inline void with_glossy_model(GlossyModel model, Work&& work) {
  switch (model) {
    case GlossyModel::coated:
      return work(std::integral_constant<GlossyModel, GlossyModel::coated>());
    case GlossyModel::conductor:
      return work(std::integral_constant<GlossyModel, GlossyModel::conductor>());
    case GlossyModel::schlick:
      return work(std::integral_constant<GlossyModel, GlossyModel::schlick>());
  }
}

/// The numbers of a point. Factors of f are multiplied by pi, because the kernels' photon flux is divided by it.
enum GlossyField : std::size_t {
  kGlossyNormal = 0,          ///< x, y, z of the shading normal, on the side of wo
  kGlossyWo = 3,              ///< x, y, z, world space
  kGlossyAlphaSquared = 6,    ///< 0: no lobe
  kGlossyLobe = 7,            ///< pi alpha^2 / (4 pi cos_o)
  kGlossyMasking = 8,         ///< 1/2 + Lambda(wo)
  kGlossyDiffuse = 9,         ///< r, g, b, times pi
  kGlossyFirst = 12,          ///< r, g, b
  kGlossySecond = 15,         ///< r, g, b
  kGlossyFirstGrazing = 18,   ///< schlick; of coated surfaces the index
  kGlossySecondGrazing = 19,  ///< schlick; of coated surfaces the thickness
  kGlossyMultiple = 20,       ///< r, g, b, times pi
  kGlossyTable = 23,          ///< start of the point's two curves in the tables, as bits
  kGlossyFields = 24,
};
inline constexpr std::size_t kGlossyIndex = kGlossyFirstGrazing, kGlossyThickness = kGlossySecondGrazing;
inline constexpr std::size_t kGlossyThrough = kGlossyFirst;

/// Number of values of a curve in the tables, at cosines (i / (kGlossyCurve - 1))^2. A point has two curves, one after
/// the other.
inline constexpr int kGlossyCurve = 32;

/// The numbers of one point.
using GlossyNumbers = std::array<float, kGlossyFields>;

/// Numbers of consecutive points: field f of point i is fields[f * stride + i]. One vector beyond the last point is
/// readable.
struct GlossyPoints {
  const float* fields = nullptr;
  std::size_t stride = 0;
  const float* tables = nullptr;
  GlossyModel model = GlossyModel::coated;
};

}  // namespace glowworm
