#include "bsdf/shaded_surface.h"

#include "core/warp.h"

namespace glowworm {

namespace {

Vec3 mirrored(Vec3 w, Vec3 normal, float cosine) { return w - normal * (2 * cosine); }

/// Makes a random choice with part of a random number: true with the given probability. u is uniform again afterwards.
bool choose(float probability, float& u) {
  const bool chosen = u < probability;
  u = chosen ? u / probability : (u - probability) / (1 - probability);
  u = std::clamp(u, 0.0f, 1 - 0x1p-24f);
  return chosen;
}

}  // namespace

template <typename F>
void ShadedSurface::for_each_source(Vec3 wi, F&& f) const {
  const float side = dot(wi, normal_), shading = dot(wi, frame_.n);
  if (shading * side > 0) f(frame_.to_local(wi));
  if ((shading - 2 * side * cosine_) * side > 0) f(frame_.to_local(mirrored(wi, normal_, side)));
}

RGB ShadedSurface::evaluate(Vec3 wo, Vec3 wi, Lobes lobes) const {
  const Vec3 view = local_view(wo);
  RGB sum(0.0f);
  for_each_source(wi, [&](Vec3 w) { sum += glowworm::evaluate(bsdf_, view, w, lobes) * std::abs(w.z); });
  return sum;
}

float ShadedSurface::pdf(Vec3 wo, Vec3 wi, Lobes lobes) const {
  const Vec3 view = local_view(wo);
  float sum = 0;
  for_each_source(wi, [&](Vec3 w) { sum += glowworm::pdf(bsdf_, view, w, lobes); });
  return sum;
}

RGB ShadedSurface::straight_transmittance(Vec3 wo) const {
  // The mirror image of the viewer's direction is not passed on in a straight line.
  return is_behind(wo) ? RGB(0.0f) : glowworm::straight_transmittance(bsdf_, frame_.to_local(wo));
}

ScatteredRay ShadedSurface::sample(Vec3 wo, float u_lobe, Vec2 u, Lobes lobes) const {
  const Vec3 view = local_view(wo);
  const BsdfSample s = glowworm::sample(bsdf_, view, u_lobe, u, lobes, Transport::radiance);
  ScatteredRay out;
  if (!s.valid) return out;
  const Vec3 w = frame_.to_world(s.wi);
  const float side = dot(w, normal_);
  const bool wrong = side * s.wi.z < 0;
  out.direction = wrong ? mirrored(w, normal_, side) : w;
  out.side = s.wi.z > 0 ? normal_ : -normal_;
  out.weight = s.weight;
  out.pdf = s.pdf;
  out.lobe = s.lobe;
  out.delta = s.delta;
  out.is_null = s.is_null && !is_behind(wo);
  out.valid = true;
  if (!s.delta && (s.wi.z - 2 * side * cosine_) * s.wi.z > 0)
    out.pdf += glowworm::pdf(bsdf_, view, frame_.to_local(mirrored(w, normal_, side)), lobes);
  return out;
}

ArrivedPhoton ShadedSurface::arrive(Vec3 back, float& u) const {
  const float side = dot(back, normal_), sign = side < 0 ? -1.0f : 1.0f;
  const float shading = sign * dot(back, frame_.n), geometric = sign * side;
  ArrivedPhoton out;
  out.back = back;
  out.factor = arrival_factor(shading, geometric, cosine_);
  const float image = shading - 2 * geometric * cosine_;
  if (image > 0 && choose(image / (shading + image), u)) out.back = mirrored(back, normal_, side);
  return out;
}

ScatteredRay ShadedSurface::scatter_photon(Vec3 back, float u_lobe, Vec2 u, float& u_mirror) const {
  const BsdfSample s = glowworm::sample(bsdf_, frame_.to_local(back), u_lobe, u, kAllLobes, Transport::flux);
  ScatteredRay out;
  if (!s.valid) return out;
  out.side = s.wi.z > 0 ? normal_ : -normal_;
  out.weight = s.weight;
  out.lobe = s.lobe;
  out.delta = s.delta;
  if (bsdf_.kind == BsdfKind::lambertian) {
    // Equal brightness from all directions: if rays leave by the geometric cosine, every direction has the same weight.
    out.direction = Frame::from_normal(out.side).to_world(square_to_cosine_hemisphere(u));
    out.valid = true;
    return out;
  }
  const Vec3 w = frame_.to_world(s.wi);
  const float shading = std::abs(s.wi.z), side = dot(w, out.side);
  // Viewer directions that map to this direction: the direction itself, and its mirror image in the shading plane.
  const float image = side - 2 * shading * cosine_;
  if (!(side > 0)) return out;
  out.direction = w;
  out.is_null = s.is_null;
  if (image > 0 && choose(image / (side + image), u_mirror)) {
    out.direction = mirrored(w, frame_.n, s.wi.z);
    out.is_null = false;
  }
  out.weight *= std::min((side + std::max(image, 0.0f)) / std::max(shading, kMinShadingCosine), kMaxShadingFactor);
  out.valid = true;
  return out;
}

}  // namespace glowworm
