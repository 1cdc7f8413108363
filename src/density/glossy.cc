#include "density/glossy.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "bsdf/reflection.h"

namespace glowworm {

namespace {

// Nearby surfaces share few materials. Where roughness changes from point to point, searching further back costs more
// than it saves.
constexpr std::size_t kLookBack = 8;

void set_color(GlossyNumbers& numbers, std::size_t field, RGB color) {
  numbers[field] = color.r;
  numbers[field + 1] = color.g;
  numbers[field + 2] = color.b;
}

void set_vector(GlossyNumbers& numbers, std::size_t field, Vec3 v) {
  numbers[field] = v.x;
  numbers[field + 1] = v.y;
  numbers[field + 2] = v.z;
}

void append_curve(std::vector<float>& tables, const bsdf_detail::Curve& curve) {
  static_assert(kGlossyCurve == bsdf_detail::kCosineNodes);
  const std::size_t first = tables.size();
  tables.resize(first + kGlossyCurve, 0.0f);
  for (std::size_t i = 0; i < kGlossyCurve; ++i)
    for (int row = 0; row < curve.count; ++row) tables[first + i] += curve.weights[row] * curve.rows[row][i];
}

}  // namespace

std::optional<GlossyModel> glossy_model(const Bsdf& bsdf) {
  const std::optional<ReflectionModel> model = reflection_model(bsdf);
  if (!model) return std::nullopt;
  switch (*model) {
    case ReflectionModel::coated:
      return GlossyModel::coated;
    case ReflectionModel::conductor:
      return GlossyModel::conductor;
    case ReflectionModel::schlick:
      return GlossyModel::schlick;
  }
  return std::nullopt;
}

GlossyNumbers GlossyPreparer::prepare(const QueryBsdf& point, GlossyModel model) {
  GlossyNumbers numbers{};
  // Kernels read the curves of points that have none; this keeps the read valid.
  if (tables_.empty()) tables_.resize(2 * kGlossyCurve, 0.0f);
  const float cosine = dot(point.n, point.wo), cosine_o = std::min(std::abs(cosine), 1.0f);
  set_vector(numbers, kGlossyNormal, cosine < 0 ? -point.n : point.n);
  set_vector(numbers, kGlossyWo, point.wo);
  numbers[kGlossyMasking] = 0.5f;
  numbers[kGlossyIndex] = 1;
  numbers[kGlossyTable] = std::bit_cast<float>(std::int32_t{-1});
  if (cosine_o == 0) return numbers;
  const IsotropicReflection f = isotropic_reflection(point.bsdf, cosine_o);
  const float alpha2 = f.alpha * f.alpha, tangent2 = (1 - cosine_o * cosine_o) / (cosine_o * cosine_o);
  numbers[kGlossyAlphaSquared] = alpha2;
  const bool diffuse = point.lobes & kDiffuse, glossy = point.lobes & kGlossy;
  numbers[kGlossyLobe] = glossy ? alpha2 / (4 * cosine_o) : 0;
  numbers[kGlossyMasking] = 0.5f * std::sqrt(1 + alpha2 * tangent2);
  set_color(numbers, kGlossyDiffuse, f.diffuse * (diffuse ? std::numbers::pi_v<float> : 0));
  set_color(numbers, kGlossyFirst, f.first);
  set_color(numbers, kGlossySecond, f.second);
  set_color(numbers, kGlossyMultiple, f.multiple * (glossy ? std::numbers::pi_v<float> : 0));
  const bool coated = model == GlossyModel::coated;
  if (coated) numbers[kGlossyThrough] = f.through;
  numbers[kGlossyFirstGrazing] = coated ? f.eta : f.first_grazing;
  numbers[kGlossySecondGrazing] = coated ? f.thickness : f.second_grazing;
  if (f.curve[0].count == 0) return numbers;

  const float alpha = point.bsdf.alpha_x, eta = coated ? f.eta : 0.0f;
  const auto last = known_.rbegin(), end = last + static_cast<std::ptrdiff_t>(std::min(kLookBack, known_.size()));
  auto known =
      std::find_if(last, end, [&](const Known& k) { return k.model == model && k.alpha == alpha && k.eta == eta; });
  std::size_t place = tables_.size();
  if (known != end) {
    place = known->place;
  } else {
    known_.push_back({model, alpha, eta, place});
    append_curve(tables_, f.curve[0]);
    append_curve(tables_, f.curve[1]);
  }
  numbers[kGlossyTable] = std::bit_cast<float>(static_cast<std::int32_t>(place));
  return numbers;
}

void GlossyPreparer::clear() {
  tables_.clear();
  known_.clear();
}

}  // namespace glowworm
