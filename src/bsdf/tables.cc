#include "bsdf/tables.h"

#include <array>
#include <memory>
#include <mutex>

#include "bsdf/fresnel.h"
#include "bsdf/microfacet.h"

namespace glowworm::bsdf_detail {
namespace {

constexpr int kAlphaNodes = 16, kEtaNodes = 17, kDepthNodes = 32;
constexpr int kBoundaries = 5;
constexpr float kMaxEta = 3, kMaxDepth = 4;
/// Numbers of quadrature points: normals around and away from the axis, cosines for the means.
constexpr int kAround = 12, kAway = 24, kMeanCosines = 96, kMeanAround = 8, kMeanAway = 12;

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

/// Calls f(wo, h, weight) for visible normals h of equal probability; the weights add up to 1.
template <class F>
void for_visible_normals(float alpha, float cosine, int around, int away, F f) {
  const float z = std::max(cosine, 1e-4f);
  const Vec3 wo{std::sqrt(std::max(0.0f, 1 - z * z)), 0, z};
  const Microfacet m{alpha, alpha};
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < away; ++j) {
      // Half of the circle is enough, because it is mirrored at the plane of incidence.
      const Vec2 u{0.5f * (i + 0.5f) / around, (j + 0.5f) / away};
      f(m, wo, m.sample_visible_normal(wo, u), 1.0f / (around * away));
    }
  }
}

/// Share of the visible facets' light that is not masked when it leaves.
float unmasked(const Microfacet& m, Vec3 wo, Vec3 wi) { return m.masking_shadowing(wo, wi) / m.masking(wo); }

struct Shares {
  float reflect = 0, transmit = 0;
};
/// @param eta far side over near side
Shares boundary_shares(float alpha, float cosine, float eta, int around, int away) {
  if (alpha == 0) {
    const float f = fresnel_dielectric(cosine, eta);
    return {f, 1 - f};
  }
  Shares out;
  for_visible_normals(alpha, cosine, around, away, [&](const Microfacet& m, Vec3 wo, Vec3 h, float weight) {
    const float f = fresnel_dielectric(dot(wo, h), eta);
    Vec3 wi = reflect(wo, h);
    if (wi.z > 0) out.reflect += weight * f * unmasked(m, wo, wi);
    if (refract(wo, h, eta, wi) && wi.z < 0) out.transmit += weight * (1 - f) * unmasked(m, wo, wi);
  });
  return out;
}

float trapped_share(float alpha, float cosine, float eta) {
  if (alpha == 0) return fresnel_dielectric(cosine, 1 / eta);
  float sum = 0;
  for_visible_normals(alpha, cosine, kAround, kAway, [&](const Microfacet& m, Vec3 wo, Vec3 h, float weight) {
    const Vec3 wi = reflect(wo, h);
    if (wi.z > 0) sum += weight * unmasked(m, wo, wi) * fresnel_dielectric(wi.z, 1 / eta);
  });
  return sum;
}

/// All tables of one index.
struct Slice {
  Row rows[kBoundaries][kAlphaNodes];
  float mean_transmit_outside[kAlphaNodes], mean_lost_inside[kAlphaNodes];  // the second: eta^2 (1 - reflected)
  float log_transmittance[kDepthNodes];

  explicit Slice(float eta) {
    for (int a = 0; a < kAlphaNodes; ++a) {
      const float alpha = node_alpha(a);
      for (int c = 0; c < kCosineNodes; ++c) {
        const float cosine = node_cosine(c);
        const Shares outside = boundary_shares(alpha, cosine, eta, kAround, kAway);
        const Shares inside = boundary_shares(alpha, cosine, 1 / eta, kAround, kAway);
        at(Boundary::reflect_outside, a)[c] = outside.reflect;
        at(Boundary::transmit_outside, a)[c] = outside.transmit;
        at(Boundary::reflect_inside, a)[c] = inside.reflect;
        at(Boundary::transmit_inside, a)[c] = inside.transmit;
        at(Boundary::trapped, a)[c] = trapped_share(alpha, cosine, eta);
      }
      integrate_means(a, eta);
    }
    integrate_absorption(eta);
  }
  Row& at(Boundary what, int alpha) { return rows[static_cast<int>(what)][alpha]; }

 private:
  void integrate_means(int a, float eta) {
    const float alpha = node_alpha(a);
    const int n = a == 0 ? 16 * kMeanCosines : kMeanCosines;
    double transmitted = 0, reflected = 0;
    for (int i = 0; i < n; ++i) {
      const float cosine = (i + 0.5f) / n;
      transmitted += 2 * cosine * boundary_shares(alpha, cosine, eta, kMeanAround, kMeanAway).transmit / n;
      reflected += 2 * cosine * boundary_shares(alpha, cosine, 1 / eta, kMeanAround, kMeanAway).reflect / n;
    }
    mean_transmit_outside[a] = static_cast<float>(transmitted);
    // Multiplied by the squared index, it hardly depends on the index (it is the transmittance from outside without
    // losses between facets), so it can be interpolated.
    mean_lost_inside[a] = static_cast<float>((1 - reflected) * eta * eta);
  }
  void integrate_absorption(float eta) {
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
      log_transmittance[d] = whole > 0 ? static_cast<float>(std::log(weakened / whole)) : 0.0f;
    }
  }
};

/// Slices are computed on first use: most scenes need one or two.
const Slice& slice(int eta_node) {
  static std::array<std::unique_ptr<const Slice>, kEtaNodes> slices;
  static std::array<std::once_flag, kEtaNodes> made;
  std::call_once(made[eta_node], [&] { slices[eta_node] = std::make_unique<const Slice>(node_eta(eta_node)); });
  return *slices[eta_node];
}

/// Calls f(slice, alpha node, weight) for the four nodes around a roughness and an index.
template <class F>
void for_nodes(float alpha, float eta, F f) {
  const Split a = split_alpha(alpha), e = split_eta(eta);
  for (int i = 0; i < 2; ++i) {
    const float eta_weight = i ? e.fraction : 1 - e.fraction;
    const Slice& s = slice(e.index + i);
    f(s, a.index, eta_weight * (1 - a.fraction));
    f(s, a.index + 1, eta_weight * a.fraction);
  }
}

struct SchlickTable {
  Row scale[kAlphaNodes], bias[kAlphaNodes];
  float mean_scale[kAlphaNodes], mean_bias[kAlphaNodes];

  SchlickTable() {
    for (int a = 0; a < kAlphaNodes; ++a) {
      const float alpha = node_alpha(a);
      for (int c = 0; c < kCosineNodes; ++c) integrate(alpha, node_cosine(c), scale[a][c], bias[a][c]);
      mean_scale[a] = mean_bias[a] = 0;
      for (int i = 0; i < kMeanCosines; ++i) {
        const float cosine = (i + 0.5f) / kMeanCosines;
        float s, b;
        integrate(alpha, cosine, s, b);
        mean_scale[a] += 2 * cosine * s / kMeanCosines;
        mean_bias[a] += 2 * cosine * b / kMeanCosines;
      }
    }
  }
  static void integrate(float alpha, float cosine, float& scale, float& bias) {
    if (alpha == 0) {
      bias = schlick_term(cosine);
      scale = 1 - bias;
      return;
    }
    scale = bias = 0;
    for_visible_normals(alpha, cosine, kAround, kAway, [&](const Microfacet& m, Vec3 wo, Vec3 h, float weight) {
      const Vec3 wi = reflect(wo, h);
      if (wi.z <= 0) return;
      const float t = schlick_term(dot(wo, h)), energy = weight * unmasked(m, wo, wi);
      scale += energy * (1 - t);
      bias += energy * t;
    });
  }
};

}  // namespace

Curve boundary_curve(Boundary what, float alpha, float eta) {
  Curve curve;
  int n = 0;
  for_nodes(alpha, eta, [&](const Slice& s, int a, float weight) {
    curve.rows[n] = s.rows[static_cast<int>(what)][a].data();
    curve.weights[n++] = weight;
  });
  return curve;
}

BoundaryMeans boundary_means(float alpha, float eta) {
  float transmitted = 0, lost = 0;
  for_nodes(alpha, eta, [&](const Slice& s, int a, float weight) {
    transmitted += weight * s.mean_transmit_outside[a];
    lost += weight * s.mean_lost_inside[a];
  });
  eta = std::clamp(eta, 1.0f, kMaxEta);
  return {transmitted, std::clamp(1 - lost / (eta * eta), 0.0f, 1.0f)};
}

float internal_transmittance(float eta, float depth) {
  if (depth <= 0) return 1;
  if (depth >= kMaxDepth) return std::exp(-2 * depth);
  const Split e = split_eta(eta), d = split(std::cbrt(depth / kMaxDepth) * (kDepthNodes - 1), kDepthNodes);
  float sum = 0;
  for (int i = 0; i < 2; ++i) {
    const float* row = slice(e.index + i).log_transmittance;
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
  return {mix(table.scale), mix(table.bias), mix_mean(table.mean_scale), mix_mean(table.mean_bias)};
}

}  // namespace glowworm::bsdf_detail
