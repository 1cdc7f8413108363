#include "scene/bsdf.h"

#include "scene/bsdf_component.h"

namespace glowworm {
namespace {

using namespace bsdf_detail;

Vec3 flipped(Vec3 w, bool flip) { return flip ? Vec3{w.x, w.y, -w.z} : w; }

/// The components among `lobes` for wo.z > 0, with their probabilities, which add up to 1.
Components components_of(const Bsdf& bsdf, bool inside, Vec3 wo, Lobes lobes) {
  Components all;
  switch (bsdf.kind) {
    case BsdfKind::lambertian:
      lambertian_components(bsdf, all);
      break;
    case BsdfKind::conductor:
      conductor_components(bsdf, wo, all);
      break;
    case BsdfKind::dielectric:
      dielectric_components(bsdf, inside, wo, all);
      break;
    case BsdfKind::thin_dielectric:
      thin_dielectric_components(bsdf, wo, all);
      break;
    default:
      break;
  }
  Components chosen;
  float total = 0;
  for (int i = 0; i < all.count; ++i) {
    if (!(all.list[i].lobe & lobes)) continue;
    Component& c = chosen.list[chosen.count++] = all.list[i];
    c.probability = mean(c.albedo);
    total += c.probability;
  }
  for (int i = 0; i < chosen.count; ++i) chosen.list[i].probability /= total;
  return chosen;
}

/// f for wo.z > 0.
RGB evaluate_above(const Bsdf& bsdf, bool inside, Vec3 wo, Vec3 wi, Lobes lobes) {
  switch (bsdf.kind) {
    case BsdfKind::lambertian:
      return evaluate_lambertian(bsdf, wo, wi, lobes);
    case BsdfKind::conductor:
      return lobes & lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y) ? evaluate_conductor(bsdf, wo, wi) : RGB(0.0f);
    case BsdfKind::dielectric:
      return lobes & lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y) ? evaluate_dielectric(bsdf, inside, wo, wi) : RGB(0.0f);
    default:
      return RGB(0.0f);
  }
}

float mixed_pdf(const Components& components, Vec3 wo, Vec3 wi) {
  float sum = 0;
  for (int i = 0; i < components.count; ++i)
    sum += components.list[i].probability * component_pdf(components.list[i], wo, wi);
  return sum;
}

}  // namespace

Lobes lobes(const Bsdf& bsdf) {
  switch (bsdf.kind) {
    case BsdfKind::lambertian:
      return static_cast<Lobes>((is_black(bsdf.diffuse) ? 0 : kDiffuseReflection) |
                                (is_black(bsdf.transmission) ? 0 : kDiffuseTransmission));
    case BsdfKind::conductor:
    case BsdfKind::dielectric:
      return lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y);
    case BsdfKind::thin_dielectric:
      return kSharp;
    default:
      return 0;
  }
}

RGB evaluate(const Bsdf& bsdf, Vec3 wo, Vec3 wi, Lobes lobes) {
  const bool inside = wo.z < 0;
  if (wo.z == 0 || wi.z == 0) return RGB(0.0f);
  return evaluate_above(bsdf, inside, flipped(wo, inside), flipped(wi, inside), lobes);
}

float pdf(const Bsdf& bsdf, Vec3 wo, Vec3 wi, Lobes lobes) {
  const bool inside = wo.z < 0;
  if (wo.z == 0 || wi.z == 0) return 0;
  wo = flipped(wo, inside);
  return mixed_pdf(components_of(bsdf, inside, wo, lobes), wo, flipped(wi, inside));
}

BsdfSample sample(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, Lobes lobes, Transport transport) {
  BsdfSample out;
  const bool inside = wo.z < 0;
  if (wo.z == 0) return out;
  wo = flipped(wo, inside);
  const Components components = components_of(bsdf, inside, wo, lobes);
  if (components.count == 0) return out;

  int chosen = 0;
  while (chosen + 1 < components.count && u_lobe >= components.list[chosen].probability)
    u_lobe -= components.list[chosen++].probability;
  const Component& c = components.list[chosen];
  u_lobe = std::min(u_lobe / c.probability, 1 - 0x1p-24f);
  Vec3 wi;
  if (!component_sample(c, wo, u_lobe, u, wi)) return out;

  out.delta = is_delta(c.shape);
  if (out.delta) {
    out.pdf = c.probability;
    out.weight = c.albedo / c.probability;
    if (c.shape == Shape::refraction && transport == Transport::radiance) out.weight *= 1 / (c.eta * c.eta);
  } else {
    out.pdf = mixed_pdf(components, wo, wi);
    if (!(out.pdf > 0) || !std::isfinite(out.pdf)) return out;
    out.weight = evaluate_above(bsdf, inside, wo, wi, lobes) * (std::abs(wi.z) / out.pdf);
    // evaluate() scales as radiance does; flux is not scaled at a refraction.
    const bool bends = c.shape == Shape::rough_dielectric || c.shape == Shape::rough_refraction;
    if (bends && wi.z < 0 && transport == Transport::flux) out.weight *= c.eta * c.eta;
  }
  out.lobe = c.lobe;
  out.wi = flipped(wi, inside);
  out.valid = is_finite(out.weight);
  return out;
}

RGB albedo(const Bsdf& bsdf, Vec3 wo, Lobes lobes) {
  const bool inside = wo.z < 0;
  const Components components = components_of(bsdf, inside, flipped(wo, inside), lobes);
  RGB sum;
  for (int i = 0; i < components.count; ++i) sum += components.list[i].albedo;
  return sum;
}

void evaluate_batch(const Bsdf& bsdf, Vec3 wo, std::span<const Vec3> wi, Lobes lobes, std::span<RGB> out) {
  for (std::size_t i = 0; i < wi.size(); ++i) out[i] = evaluate(bsdf, wo, wi[i], lobes);
}

}  // namespace glowworm
