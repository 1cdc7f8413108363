#include "bsdf/tables.h"

#include <array>
#include <memory>
#include <mutex>

#include "bsdf/fresnel.h"
#include "bsdf/microfacet.h"

namespace glowworm::bsdf_detail {
namespace {

constexpr int kAlphaNodes = 32, kEtaNodes = 17, kDepthNodes = 32;
constexpr int kBoundaries = static_cast<int>(Boundary::schlick_lost_f90_inside) + 1;
constexpr float kMaxEta = 3, kMaxDepth = 4;
/// Numbers of quadrature points: normals around and away from the axis.
constexpr int kAround = 24, kAway = 48;

using Row = std::array<float, kCosineNodes>;

float node_cosine(int i) { return static_cast<float>(i * i) / ((kCosineNodes - 1) * (kCosineNodes - 1)); }
float node_alpha(int i) { return static_cast<float>(i * i) / ((kAlphaNodes - 1) * (kAlphaNodes - 1)); }
/// Nodes of the index are equidistant in the amplitude reflected at normal incidence.
float node_eta(int i) {
  const float most = (kMaxEta - 1) / (kMaxEta + 1), s = most * i / (kEtaNodes - 1);
  return (1 + s) / (1 - s);
}

struct Split {
  int index;
  float fraction;
};
Split split(float x, int nodes) {
  x = std::clamp(x, 0.0f, static_cast<float>(nodes - 1));
  const int i = std::min(static_cast<int>(x), nodes - 2);
  return {i, x - i};
}
Split split_alpha(float alpha) {
  return split(std::sqrt(std::clamp(alpha, 0.0f, 1.0f)) * (kAlphaNodes - 1), kAlphaNodes);
}
Split split_eta(float eta) {
  const float most = (kMaxEta - 1) / (kMaxEta + 1);
  return split((eta - 1) / (eta + 1) / most * (kEtaNodes - 1), kEtaNodes);
}

/// Calls f(microfacet, wo, h, weight) for visible normals h; the weights add up to 1.
template <class F>
void for_visible_normals(float alpha, float cosine, F f) {
  const float z = std::max(cosine, 1e-4f);
  const Vec3 wo{std::sqrt(std::max(0.0f, 1 - z * z)), 0, z};
  const Microfacet m{alpha, alpha};
  for (int j = 0; j < kAway; ++j) {
    // Denser towards the steepest normals, where masking changes fast.
    const float rest = 1 - (j + 0.5f) / kAway;
    // Half of the circle is enough, because it is mirrored at the plane of incidence.
    for (int i = 0; i < kAround; ++i)
      f(m, wo, m.sample_visible_normal(wo, {0.5f * (i + 0.5f) / kAround, 1 - rest * rest}),
        2 * rest / (kAround * kAway));
  }
}

/// Share of the visible facets' light that is not masked when it leaves.
float unmasked(const Microfacet& m, Vec3 wo, Vec3 wi) { return m.masking_shadowing(wo, wi) / m.masking(wo); }

/// Mean weighted by the cosine of a function that is linear between the nodes, as Curve reads it.
float mean_over_cosines(const Row& row) {
  double sum = 0;
  for (int i = 0; i + 1 < kCosineNodes; ++i) {
    const double a = node_cosine(i), b = node_cosine(i + 1);
    sum += (b - a) / 3 * (row[i] * (2 * a + b) + row[i + 1] * (a + 2 * b));
  }
  return static_cast<float>(sum);
}

/// Shares of light from one side, and what Schlick's Fresnel term makes lost (Boundary).
struct Shares {
  float reflect = 0, transmit = 0, lost = 0, schlick_lost = 0, schlick_lost_f0 = 0, schlick_lost_f90 = 0;
};
/// @param eta far side over near side
Shares boundary_shares(float alpha, float cosine, float eta) {
  Shares out;
  if (alpha == 0) {
    out.reflect = fresnel_dielectric(cosine, eta);
    out.transmit = 1 - out.reflect;
    return out;
  }
  for_visible_normals(alpha, cosine, [&](const Microfacet& m, Vec3 wo, Vec3 h, float weight) {
    const float near = dot(wo, h), f = fresnel_dielectric(near, eta);
    const Vec3 mirrored = reflect(wo, h);
    Vec3 refracted;
    const bool totally_reflected = !refract(wo, h, eta, refracted);
    const float up = mirrored.z > 0 ? weight * unmasked(m, wo, mirrored) : 0.0f;
    const float down = !totally_reflected && refracted.z < 0 ? weight * unmasked(m, wo, refracted) : 0.0f;
    out.reflect += f * up;
    out.transmit += (1 - f) * down;
    out.schlick_lost += weight - (totally_reflected ? up : down);
    if (totally_reflected) return;
    const float t = schlick_term(eta > 1 ? near : -dot(refracted, h));
    out.schlick_lost_f0 += (1 - t) * (down - up);
    out.schlick_lost_f90 += t * (down - up);
  });
  out.lost = std::max(0.0f, 1 - out.reflect - out.transmit);
  return out;
}

float trapped_share(float alpha, float cosine, float eta) {
  if (alpha == 0) return fresnel_dielectric(cosine, eta);
  const float inside = std::sqrt(std::max(0.0f, 1 - (1 - cosine * cosine) / (eta * eta)));
  float sum = 0;
  for_visible_normals(alpha, inside, [&](const Microfacet& m, Vec3 wo, Vec3 h, float weight) {
    const Vec3 wi = reflect(wo, h);
    if (wi.z > 0) sum += weight * unmasked(m, wo, wi) * fresnel_dielectric(wi.z, 1 / eta);
  });
  return sum;
}

/// The tables of one roughness and index.
struct Cell {
  Row rows[kBoundaries];
  float means[kBoundaries];

  Cell(float alpha, float eta) {
    for (int c = 0; c < kCosineNodes; ++c) {
      const float cosine = node_cosine(c);
      const Shares outside = boundary_shares(alpha, cosine, eta), inside = boundary_shares(alpha, cosine, 1 / eta);
      const auto set = [&](Boundary what, float share) { rows[static_cast<int>(what)][c] = share; };
      set(Boundary::reflect_outside, outside.reflect);
      set(Boundary::transmit_outside, outside.transmit);
      set(Boundary::lost_outside, outside.lost);
      set(Boundary::reflect_inside, inside.reflect);
      set(Boundary::transmit_inside, inside.transmit);
      set(Boundary::lost_inside, inside.lost);
      set(Boundary::trapped, trapped_share(alpha, cosine, eta));
      set(Boundary::schlick_lost_outside, outside.schlick_lost);
      set(Boundary::schlick_lost_f0_outside, outside.schlick_lost_f0);
      set(Boundary::schlick_lost_f90_outside, outside.schlick_lost_f90);
      set(Boundary::schlick_lost_inside, inside.schlick_lost);
      set(Boundary::schlick_lost_f0_inside, inside.schlick_lost_f0);
      set(Boundary::schlick_lost_f90_inside, inside.schlick_lost_f90);
    }
    for (int i = 0; i < kBoundaries; ++i) means[i] = mean_over_cosines(rows[i]);
    // Surfaces without roughness evaluate the Fresnel term itself, not its table.
    if (alpha == 0) means[static_cast<int>(Boundary::transmit_outside)] = 1 - mean_fresnel(eta);
  }

 private:
  static float mean_fresnel(float eta) {
    constexpr int n = 1024;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const float cosine = (i + 0.5f) / n;
      sum += 2 * cosine * fresnel_dielectric(cosine, eta) / n;
    }
    return static_cast<float>(sum);
  }
};

/// Logarithms of internal_transmittance() for one index.
std::array<float, kDepthNodes> integrate_absorption(float eta) {
  std::array<float, kDepthNodes> logs;
  const int n = 4096;
  for (int d = 0; d < kDepthNodes; ++d) {
    const double t = static_cast<double>(d) / (kDepthNodes - 1), depth = kMaxDepth * t * t * t;
    double weakened = 0, whole = 0;
    for (int i = 0; i < n; ++i) {
      const double cosine = (i + 0.5) / n;
      const double reflected = cosine * fresnel_dielectric(static_cast<float>(cosine), 1 / eta);
      whole += reflected;
      weakened += reflected * std::exp(-2 * depth / cosine);
    }
    logs[d] = whole > 0 ? static_cast<float>(std::log(weakened / whole)) : 0.0f;
  }
  return logs;
}

// Tables are computed on first use: most scenes need a few.
const Cell& cell(int alpha_node, int eta_node) {
  static std::array<std::unique_ptr<const Cell>, kAlphaNodes * kEtaNodes> cells;
  static std::array<std::once_flag, kAlphaNodes * kEtaNodes> made;
  const int i = eta_node * kAlphaNodes + alpha_node;
  std::call_once(made[i], [&] { cells[i] = std::make_unique<const Cell>(node_alpha(alpha_node), node_eta(eta_node)); });
  return *cells[i];
}
const std::array<float, kDepthNodes>& absorption(int eta_node) {
  static std::array<std::array<float, kDepthNodes>, kEtaNodes> tables;
  static std::array<std::once_flag, kEtaNodes> made;
  std::call_once(made[eta_node], [&] { tables[eta_node] = integrate_absorption(node_eta(eta_node)); });
  return tables[eta_node];
}

/// Calls f(cell, weight) for the four nodes around a roughness and an index; those of weight 0 are not computed.
template <class F>
void for_nodes(float alpha, float eta, F f) {
  const Split a = split_alpha(alpha), e = split_eta(eta);
  const Cell* last = nullptr;
  for (int i = 0; i < 4; ++i) {
    const float weight = (i / 2 ? e.fraction : 1 - e.fraction) * (i % 2 ? a.fraction : 1 - a.fraction);
    if (weight > 0) last = &cell(a.index + i % 2, e.index + i / 2);
    if (last) f(*last, weight);
  }
}

struct SchlickTable {
  enum { scale, bias, scale_out, bias_out, kCount };
  Row rows[kCount][kAlphaNodes];
  float mean_scale[kAlphaNodes], mean_bias[kAlphaNodes];

  SchlickTable() {
    for (int a = 0; a < kAlphaNodes; ++a) {
      for (int c = 0; c < kCosineNodes; ++c) {
        const auto shares = integrate(node_alpha(a), node_cosine(c));
        for (int i = 0; i < kCount; ++i) rows[i][a][c] = shares[i];
      }
      mean_scale[a] = mean_over_cosines(rows[scale][a]);
      mean_bias[a] = mean_over_cosines(rows[bias][a]);
    }
  }
  static std::array<float, kCount> integrate(float alpha, float cosine) {
    if (alpha == 0) {
      const float t = schlick_term(cosine);
      return {1 - t, t, (1 - t) * t, t * t};
    }
    std::array<float, kCount> sums{};
    for_visible_normals(alpha, cosine, [&](const Microfacet& m, Vec3 wo, Vec3 h, float weight) {
      const Vec3 wi = reflect(wo, h);
      if (wi.z <= 0) return;
      const float t = schlick_term(dot(wo, h)), energy = weight * unmasked(m, wo, wi), out = schlick_term(wi.z);
      sums[scale] += energy * (1 - t);
      sums[bias] += energy * t;
      sums[scale_out] += energy * (1 - t) * out;
      sums[bias_out] += energy * t * out;
    });
    // Rounding must not make more light than arrives.
    const float excess = std::max(1.0f, sums[scale] + sums[bias]);
    for (float& sum : sums) sum /= excess;
    return sums;
  }
};

}  // namespace

Curve boundary_curve(Boundary what, float alpha, float eta) {
  Curve curve;
  int n = 0;
  const float* row = nullptr;
  for_nodes(alpha, eta, [&](const Cell& c, float weight) {
    row = c.rows[static_cast<int>(what)].data();
    curve.rows[n] = row;
    curve.weights[n++] = weight;
  });
  while (n < 4) curve.rows[n++] = row;
  return curve;
}

float boundary_mean(Boundary what, float alpha, float eta) {
  float mean = 0;
  for_nodes(alpha, eta, [&](const Cell& c, float weight) { mean += weight * c.means[static_cast<int>(what)]; });
  return mean;
}

float internal_transmittance(float eta, float depth) {
  if (depth <= 0) return 1;
  if (depth >= kMaxDepth) return std::exp(-2 * depth);
  const Split e = split_eta(eta), d = split(std::cbrt(depth / kMaxDepth) * (kDepthNodes - 1), kDepthNodes);
  float sum = 0;
  for (int i = 0; i < 2; ++i) {
    const std::array<float, kDepthNodes>& row = absorption(e.index + i);
    sum += (i ? e.fraction : 1 - e.fraction) * (row[d.index] + (row[d.index + 1] - row[d.index]) * d.fraction);
  }
  return std::exp(sum);
}

SchlickCurves schlick_curves(float alpha) {
  static const SchlickTable table;
  const Split a = split_alpha(alpha);
  const float w = a.fraction;
  const auto mix = [&](const Row* rows) {
    const float *low = rows[a.index].data(), *high = rows[a.index + 1].data();
    return Curve{{low, high, low, low}, {1 - w, w, 0, 0}};
  };
  const auto mix_mean = [&](const float* means) { return means[a.index] * (1 - w) + means[a.index + 1] * w; };
  using T = SchlickTable;
  return {mix(table.rows[T::scale]),    mix(table.rows[T::bias]),   mix(table.rows[T::scale_out]),
          mix(table.rows[T::bias_out]), mix_mean(table.mean_scale), mix_mean(table.mean_bias)};
}

}  // namespace glowworm::bsdf_detail
