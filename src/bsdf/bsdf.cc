#include "bsdf/bsdf.h"

#include <cstddef>
#include <iterator>

#include "bsdf/component.h"
#include "bsdf/measured.h"
#include "core/warp.h"

namespace glowworm {
namespace {

using namespace bsdf_detail;

Vec3 mirrored(Vec3 w, bool below) { return below ? Vec3{w.x, w.y, -w.z} : w; }

View view_of(const Bsdf& bsdf, Vec3 wo, Lobes lobes) { return {bsdf, wo.z < 0, mirrored(wo, wo.z < 0), lobes}; }

/// What a kind of BSDF is made of, and its values.
struct Model {
  void (*components)(const View& view, Components& out);
  void (*evaluate)(const View& view, std::span<const Vec3> wi, std::span<RGB> out);
};
constexpr Model kModels[] = {
    {lambertian_components, evaluate_lambertian},
    {conductor_components, evaluate_conductor},
    {dielectric_components, evaluate_dielectric},
    {thin_dielectric_components, [](const View&, std::span<const Vec3>, std::span<RGB> out) { fill_black(out); }},
    {coated_diffuse_components, evaluate_coated_diffuse},
    {coated_conductor_components, evaluate_coated_conductor},
    {metallic_roughness_components, evaluate_metallic_roughness},
    {measured_components, evaluate_measured},
};
static_assert(std::size(kModels) == static_cast<std::size_t>(BsdfKind::measured) + 1);

const Model& model_of(const View& view) { return kModels[static_cast<std::size_t>(view.bsdf.kind)]; }

Components all_components(const View& view) {
  Components all;
  model_of(view).components(view, all);
  return all;
}

/// The components among the chosen lobes, with their probabilities, which add up to 1.
Components chosen_components(const View& view) {
  const Components all = all_components(view);
  Components chosen;
  float total = 0;
  for (int i = 0; i < all.count; ++i) {
    if (!(all.list[i].lobe & view.lobes)) continue;
    Component& c = chosen.list[chosen.count++] = all.list[i];
    c.probability = mean(c.albedo);
    total += c.probability;
  }
  for (int i = 0; i < chosen.count; ++i) chosen.list[i].probability /= total;
  return chosen;
}

/// The sum of the albedos of those components that `counts` accepts.
template <class Counts>
RGB sum_of_albedos(const View& view, Counts counts) {
  const Components components = all_components(view);
  RGB sum;
  for (int i = 0; i < components.count; ++i)
    if (counts(components.list[i])) sum += components.list[i].albedo;
  return sum;
}

float mixed_pdf(const Components& components, Vec3 wo, Vec3 wi) {
  float sum = 0;
  for (int i = 0; i < components.count; ++i)
    sum += components.list[i].probability * component_pdf(components.list[i], wo, wi);
  return sum;
}

/// A fast version of sample() for diffuse reflection only, the most common case: the same result as the general code.
BsdfSample sample_diffuse(RGB reflectance, Vec3 wo, Vec2 u, Lobes lobes) {
  BsdfSample out;
  if (!(lobes & kDiffuseReflection) || !(max_component(reflectance) > 0)) return out;
  const Vec3 wi = square_to_cosine_hemisphere(u);
  if (!(wi.z > 0)) return out;
  out.wi = mirrored(wi, wo.z < 0);
  out.lobe = kDiffuseReflection;
  out.pdf = cosine_hemisphere_pdf(wi.z);
  if (!(out.pdf > 0)) return out;
  out.weight = reflectance * kInversePi * (wi.z / out.pdf);
  out.valid = is_finite(out.weight);
  return out;
}

}  // namespace

Lobes lobes(const Bsdf& bsdf) {
  if (is_lambertian(bsdf)) return max_component(bsdf.diffuse) > 0 ? kDiffuseReflection : Lobes{0};
  if (bsdf.kind == BsdfKind::measured)
    return static_cast<Lobes>((bsdf.measured->is_black(false) ? 0 : kGlossy) |
                              (bsdf.measured->is_black(true) ? 0 : kDiffuseTransmission));
  // For a slanted direction, every other component is included.
  Lobes all = 0;
  for (const float z : {0.6f, -0.6f}) {
    const Components components = all_components(view_of(bsdf, {0.8f, 0, z}, kAllLobes));
    for (int i = 0; i < components.count; ++i) all |= components.list[i].lobe;
  }
  // A smooth coat with a normal of its own is visible from some directions only.
  if (bsdf.kind == BsdfKind::metallic_roughness && bsdf.coat > 0)
    all |= lobe_of_alpha(bsdf.coat_alpha, bsdf.coat_alpha);
  return all;
}

RGB evaluate(const Bsdf& bsdf, Vec3 wo, Vec3 wi, Lobes lobes) {
  RGB f;
  evaluate_batch(bsdf, wo, {&wi, 1}, lobes, {&f, 1});
  return f;
}

std::optional<ReflectionModel> reflection_model(const Bsdf& bsdf) {
  if (bsdf.alpha_x != bsdf.alpha_y) return std::nullopt;
  switch (bsdf.kind) {
    case BsdfKind::coated_diffuse:
      return ReflectionModel::coated;
    case BsdfKind::conductor:
      return bsdf.use_reflectance ? ReflectionModel::schlick : ReflectionModel::conductor;
    case BsdfKind::metallic_roughness:
      if (bsdf.transmission_weight != 0 || bsdf.coat != 0 || bsdf.iridescence != 0 || bsdf.diffuse_transmission != 0 ||
          !is_black(bsdf.sheen))
        return std::nullopt;
      return ReflectionModel::schlick;
    default:
      return std::nullopt;
  }
}

IsotropicReflection isotropic_reflection(const Bsdf& bsdf, float cosine_o) {
  if (bsdf.kind == BsdfKind::coated_diffuse) return reflection_of_coated_diffuse(bsdf, cosine_o);
  if (bsdf.kind == BsdfKind::conductor) return reflection_of_conductor(bsdf, cosine_o);
  return reflection_of_metallic_roughness(bsdf, cosine_o);
}

void evaluate_batch(const Bsdf& bsdf, Vec3 wo, std::span<const Vec3> wi, Lobes lobes, std::span<RGB> out) {
  if (wo.z == 0) return fill_black(out);
  const View view = view_of(bsdf, wo, lobes);
  model_of(view).evaluate(view, wi, out);
}

float pdf(const Bsdf& bsdf, Vec3 wo, Vec3 wi, Lobes lobes) {
  if (wo.z == 0 || wi.z == 0) return 0;
  if (is_lambertian(bsdf)) {
    if (!(lobes & kDiffuseReflection) || !(max_component(bsdf.diffuse) > 0)) return 0;
    return cosine_hemisphere_pdf(wo.z < 0 ? -wi.z : wi.z);
  }
  const View view = view_of(bsdf, wo, lobes);
  return mixed_pdf(chosen_components(view), view.wo, mirrored(wi, view.inside));
}

BsdfSample sample(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, Lobes lobes, Transport transport) {
  BsdfSample out;
  if (wo.z == 0) return out;
  if (is_lambertian(bsdf)) return sample_diffuse(bsdf.diffuse, wo, u, lobes);
  const View view = view_of(bsdf, wo, lobes);
  const Components components = chosen_components(view);
  if (components.count == 0) return out;

  int chosen = 0;
  while (chosen + 1 < components.count && u_lobe >= components.list[chosen].probability)
    u_lobe -= components.list[chosen++].probability;
  const Component& c = components.list[chosen];
  u_lobe = std::clamp(u_lobe / c.probability, 0.0f, 1 - 0x1p-24f);
  Vec3 wi;
  if (!component_sample(c, view.wo, u_lobe, u, wi)) return out;

  out.wi = mirrored(wi, view.inside);
  out.lobe = c.lobe;
  out.delta = is_delta(c.shape);
  out.is_null = c.shape == Shape::straight;
  if (out.delta) {
    out.pdf = c.probability;
    out.weight = c.albedo / c.probability;
    // Refraction scales radiance, but not the components' own numbers and flux.
    if (wi.z < 0 && transport == Transport::radiance) out.weight *= 1 / (c.eta * c.eta);
  } else {
    out.pdf = mixed_pdf(components, view.wo, wi);
    if (!(out.pdf > 0) || !std::isfinite(out.pdf)) return out;
    RGB f;
    model_of(view).evaluate(view, {&out.wi, 1}, {&f, 1});
    out.weight = f * (std::abs(wi.z) / out.pdf);
    if (wi.z < 0 && transport == Transport::flux) out.weight *= c.eta * c.eta;
  }
  out.valid = is_finite(out.weight);
  return out;
}

RGB choose_wavelength(Bsdf& bsdf, RGB throughput, float u) {
  if (!(bsdf.dispersion > 0) || bsdf.kind != BsdfKind::metallic_roughness) return RGB(1.0f);
  const float total = throughput.r + throughput.g + throughput.b;
  if (!(total > 0)) return RGB(1.0f);
  int chosen = 0;
  float left = u * total;
  while (chosen < 2 && (left >= throughput[chosen] || !(throughput[chosen] > 0))) left -= throughput[chosen++];
  if (!(throughput[chosen] > 0)) chosen = throughput.r > 0 ? 0 : 1;  // in case of rounding in the last bits of the sum
  const float half_spread = (bsdf.eta.r - 1) * bsdf.dispersion / 40;
  bsdf.eta = RGB(std::max(1.0f, bsdf.eta.r + static_cast<float>(chosen - 1) * half_spread));
  bsdf.dispersion = 0;
  RGB factor(0.0f);
  factor[chosen] = total / throughput[chosen];
  return factor;
}

RGB albedo(const Bsdf& bsdf, Vec3 wo, Lobes lobes) {
  if (is_lambertian(bsdf)) return lobes & kDiffuseReflection ? bsdf.diffuse : RGB(0.0f);
  return sum_of_albedos(view_of(bsdf, wo, lobes), [&](const Component& c) { return (c.lobe & lobes) != 0; });
}

LobeChoice choose_lobes(const Bsdf& bsdf, Vec3 wo, float u) {
  LobeChoice chosen;
  if (wo.z == 0) return chosen;
  const Components components = chosen_components(view_of(bsdf, wo, kAllLobes));
  float below = 0;
  for (const Lobes lobes : {kDiffuse, kGlossy, kSpecular}) {
    float probability = 0;
    for (int i = 0; i < components.count; ++i)
      if (components.list[i].lobe & lobes) probability += components.list[i].probability;
    if (probability > 0) chosen = {lobes, probability};
    below += probability;
    if (u < below) break;
  }
  return chosen;
}

RGB straight_transmittance(const Bsdf& bsdf, Vec3 wo) {
  return sum_of_albedos(view_of(bsdf, wo, kSpecular), [](const Component& c) { return c.shape == Shape::straight; });
}

}  // namespace glowworm
