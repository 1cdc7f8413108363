#include "bsdf/albedos.h"

#include <algorithm>
#include <cmath>

#include "bsdf/fresnel.h"

namespace glowworm::bsdf_detail {
namespace {

/// Numbers of quadrature points: normals around and away from the axis. Brushed surfaces have no plane of symmetry.
constexpr int kAround = 24, kAway = 48, kAroundBrushed = 16, kAwayBrushed = 16;

Microfacet microfacet_of(Facets facets) { return {facets.alpha, facets.alpha * std::max(facets.ratio, 1e-2f)}; }

Vec3 direction_at(Facets facets, Place at) {
  const float z = std::max(at.cosine, 1e-4f), sine = std::sqrt(std::max(0.0f, 1 - z * z));
  if (facets.ratio >= 1) return {sine, 0, z};
  const float projected = facets.ratio + at.along * (1 - facets.ratio), r2 = facets.ratio * facets.ratio;
  const float cos2 = std::clamp((projected * projected - r2) / (1 - r2), 0.0f, 1.0f);
  return {sine * std::sqrt(cos2), sine * std::sqrt(1 - cos2), z};
}

/// Calls f(microfacet, wo, h, weight) for visible normals h; the weights add up to 1.
template <class F>
void for_visible_normals(Facets facets, Place at, F f) {
  const Microfacet m = microfacet_of(facets);
  const Vec3 wo = direction_at(facets, at);
  const bool brushed = facets.ratio < 1;
  const int around = brushed ? kAroundBrushed : kAround, away = brushed ? kAwayBrushed : kAway;
  // Half of the circle is enough for others, because it is mirrored at the plane of incidence.
  const float circle = brushed ? 1.0f : 0.5f;
  for (int j = 0; j < away; ++j) {
    // Denser towards the steepest normals, where masking changes fast.
    const float rest = 1 - (j + 0.5f) / away;
    for (int i = 0; i < around; ++i)
      f(m, wo, m.sample_visible_normal(wo, {circle * (i + 0.5f) / around, 1 - rest * rest}),
        2 * rest / (around * away));
  }
}

/// Share of the visible facets' light that is not masked when it leaves.
float unmasked(const Microfacet& m, Vec3 wo, Vec3 wi) { return m.masking_shadowing(wo, wi) / m.masking(wo); }

/// Calls f(microfacet, wo, h, weight, wi, energy) for light that facets mirror to above.
template <class F>
void for_mirrored(Facets facets, Place at, F f) {
  for_visible_normals(facets, at, [&](const Microfacet& m, Vec3 wo, Vec3 h, float weight) {
    const Vec3 wi = reflect(wo, h);
    if (wi.z > 0) f(dot(wo, h), wi, weight * unmasked(m, wo, wi));
  });
}

/// Shares of light from one side, each run in the order of Boundary.
struct Shares {
  std::array<float, 3> fates{};         ///< reflected, transmitted, lost
  std::array<float, 3> schlick_lost{};  ///< by facets with Schlick's Fresnel term: in all, by f0, by f90
  std::array<float, 6> passed{};        ///< by them: the same, and the same weighted by the term of the way out
};
/// @param eta far side over near side
Shares boundary_shares(Facets facets, Place at, float eta) {
  Shares out;
  if (facets.alpha == 0) {
    const float reflected = fresnel_dielectric(at.cosine, eta);
    out.fates = {reflected, 1 - reflected, 0};
    return out;
  }
  for_visible_normals(facets, at, [&](const Microfacet& m, Vec3 wo, Vec3 h, float weight) {
    const float near = dot(wo, h), f = fresnel_dielectric(near, eta);
    const Vec3 mirrored = reflect(wo, h);
    Vec3 refracted;
    const bool totally_reflected = !refract(wo, h, eta, refracted);
    const float up = mirrored.z > 0 ? weight * unmasked(m, wo, mirrored) : 0.0f;
    const float down = !totally_reflected && refracted.z < 0 ? weight * unmasked(m, wo, refracted) : 0.0f;
    out.fates[0] += f * up;
    out.fates[1] += (1 - f) * down;
    out.schlick_lost[0] += weight - (totally_reflected ? up : down);
    if (totally_reflected) return;
    const float t = schlick_term(eta > 1 ? near : -dot(refracted, h)), leaving = schlick_term(-refracted.z);
    const float in_all[] = {down, down * leaving}, parts[] = {1 - t, t};
    for (int part = 0; part < 2; ++part) out.schlick_lost[1 + part] += parts[part] * (down - up);
    for (int way = 0; way < 2; ++way) {
      out.passed[3 * way] += in_all[way];
      for (int part = 0; part < 2; ++part) out.passed[3 * way + 1 + part] += in_all[way] * parts[part];
    }
  });
  out.fates[2] = std::max(0.0f, 1 - out.fates[0] - out.fates[1]);
  return out;
}

float trapped_share(Facets facets, Place at, float eta) {
  if (facets.alpha == 0) return fresnel_dielectric(at.cosine, eta);
  const float inside = std::sqrt(std::max(0.0f, 1 - (1 - at.cosine * at.cosine) / (eta * eta)));
  float sum = 0;
  for_mirrored(facets, {inside, at.along},
               [&](float, Vec3 wi, float energy) { sum += energy * fresnel_dielectric(wi.z, 1 / eta); });
  return sum;
}

/// The polynomials that are 1 at one node and 0 at the others.
std::array<float, kFresnelNodes> polynomials(float cosine) {
  std::array<float, kFresnelNodes> out;
  for (int i = 0; i < kFresnelNodes; ++i) {
    out[i] = 1;
    for (int j = 0; j < kFresnelNodes; ++j)
      if (j != i) out[i] *= (cosine - kFresnelCosines[j]) / (kFresnelCosines[i] - kFresnelCosines[j]);
  }
  return out;
}

}  // namespace

// Chebyshev's nodes, between which polynomials do not oscillate.
const float kFresnelCosines[kFresnelNodes] = {0.01703709f, 0.14644661f, 0.37059048f,
                                              0.62940952f, 0.85355339f, 0.98296291f};

BoundaryShares integrate_boundary(Facets facets, Place at, float eta) {
  const Shares outside = boundary_shares(facets, at, eta), inside = boundary_shares(facets, at, 1 / eta);
  BoundaryShares out{};
  auto next = out.begin();
  const auto put = [&next](const auto& shares) { next = std::copy(shares.begin(), shares.end(), next); };
  put(outside.fates);
  put(inside.fates);
  *next++ = trapped_share(facets, at, eta);
  put(outside.schlick_lost);
  put(inside.schlick_lost);
  put(inside.passed);
  return out;
}

std::array<float, 5> integrate_schlick(Facets facets, Place at) {
  if (facets.alpha == 0) {
    const float t = schlick_term(at.cosine);
    return {1 - t, t, (1 - t) * t, t * t, 1};
  }
  std::array<float, 5> sums{};
  for_mirrored(facets, at, [&](float near, Vec3 wi, float energy) {
    const float t = schlick_term(near), out = schlick_term(wi.z);
    sums[0] += energy * (1 - t);
    sums[1] += energy * t;
    sums[2] += energy * (1 - t) * out;
    sums[3] += energy * t * out;
  });
  sums[4] = sums[0] + sums[1];
  // Rounding must not make more light than arrives.
  const float excess = std::max(1.0f, sums[4]);
  for (float& sum : sums) sum /= excess;
  return sums;
}

std::array<float, kFresnelNodes> integrate_fresnel(Facets facets, Place at) {
  if (facets.alpha == 0) return polynomials(at.cosine);
  std::array<float, kFresnelNodes> sums{};
  for_mirrored(facets, at, [&](float near, Vec3, float energy) {
    const auto values = polynomials(near);
    for (int i = 0; i < kFresnelNodes; ++i) sums[i] += energy * values[i];
  });
  return sums;
}

std::array<float, kAlongNodes> mean_weights_along(float ratio) {
  std::array<float, kAlongNodes> weights{};
  if (ratio >= 1) {
    weights[0] = 1;
    return weights;
  }
  constexpr int kAzimuths = 64;
  const Microfacet m = microfacet_of({1, ratio});
  for (int i = 0; i < kAzimuths; ++i) {
    const float azimuth = (i + 0.5f) / kAzimuths * kPi / 2;
    const float x = place_of(m, {std::cos(azimuth), std::sin(azimuth), 0}).along * (kAlongNodes - 1);
    const int low = std::min(static_cast<int>(x), kAlongNodes - 2);
    weights[low] += (1 - (x - low)) / kAzimuths;
    weights[low + 1] += (x - low) / kAzimuths;
  }
  return weights;
}

}  // namespace glowworm::bsdf_detail
