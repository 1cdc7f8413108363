#include "bsdf/sheen.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bsdf/fresnel.h"

namespace glowworm::bsdf_detail {

namespace {

constexpr float kMinAlpha = 0.01f;
constexpr int kSheenAlphaNodes = 32;

/// Lambda of the Charlie distribution, fitted (Estevez and Kulla 2017, section 3), without its softened terminator,
/// which is not reciprocal.
float lambda(float cosine, float alpha) {
  const float t = (1 - alpha) * (1 - alpha);
  const auto mixed = [&](float at_0, float at_1) { return t * at_0 + (1 - t) * at_1; };
  const float a = mixed(25.3245f, 21.5473f), b = mixed(3.32435f, 3.82987f), c = mixed(0.16801f, 0.19823f),
              d = mixed(-1.27393f, -1.97760f), e = mixed(-4.85967f, -4.32054f);
  const auto l = [&](float x) { return a / (1 + b * std::pow(x, c)) + d * x + e; };
  return cosine < 0.5f ? std::exp(l(cosine)) : std::exp(2 * l(0.5f) - l(1 - cosine));
}

float charlie(Vec3 wo, Vec3 wi, float alpha) {
  const Vec3 sum = wo + wi;
  const float l2 = length_squared(sum);
  if (!(l2 > 0)) return 0;
  const float sin2 = std::max(0.0f, 1 - sum.z * sum.z / l2);
  const float distribution = (2 + 1 / alpha) * std::pow(sin2, 0.5f / alpha) * (kInversePi / 2);
  return distribution * std::min(1.0f, 1 / ((1 + lambda(wo.z, alpha) + lambda(wi.z, alpha)) * 4 * wo.z * wi.z));
}

/// Alphas and cosines of the nodes are squares of equal steps: denser where the function is more curved.
float node(int i, int count) {
  const float x = static_cast<float>(i) / static_cast<float>(count - 1);
  return x * x;
}

using Table = std::array<std::array<float, kCosineNodes>, kSheenAlphaNodes>;

/// Albedos before they are limited, and the same for Sheen::albedo_out().
struct Tables {
  Table albedo{}, out{};
};

/// Integrates over the hemisphere.
Tables integrate() {
  constexpr int kPolar = 64, kAzimuth = 32;
  Tables tables;
  for (int row = 0; row < kSheenAlphaNodes; ++row) {
    const float alpha = std::max(kMinAlpha, node(row, kSheenAlphaNodes));
    for (int column = 0; column < kCosineNodes; ++column) {
      const float cosine = std::max(1e-3f, node(column, kCosineNodes));
      const Vec3 wo{std::sqrt(1 - cosine * cosine), 0, cosine};
      double sum = 0, sum_out = 0;
      for (int p = 0; p < kPolar; ++p) {
        // Equal steps of angle, to resolve grazing light.
        const float theta = (static_cast<float>(p) + 0.5f) * (kPi / 2 / kPolar);
        for (int a = 0; a < kAzimuth; ++a) {
          const float phi = (static_cast<float>(a) + 0.5f) * (kPi / kAzimuth);
          const Vec3 wi{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
          const auto part = static_cast<double>(charlie(wo, wi, alpha) * wi.z * std::sin(theta));
          sum += part;
          sum_out += part * schlick_term(wi.z);
        }
      }
      constexpr double kStep = (kPi / 2 / kPolar) * (2 * kPi / kAzimuth);
      tables.albedo[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = static_cast<float>(sum * kStep);
      tables.out[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = static_cast<float>(sum_out * kStep);
    }
  }
  return tables;
}

const Tables& tables() {
  static const Tables all = integrate();
  return all;
}

float read_rows(const float* const rows[2], float mix, float cosine) {
  const float x = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * (kCosineNodes - 1);
  const int i = std::min(static_cast<int>(x), kCosineNodes - 2);
  const float t =
      (std::clamp(cosine, 0.0f, 1.0f) - node(i, kCosineNodes)) / (node(i + 1, kCosineNodes) - node(i, kCosineNodes));
  const auto row = [&](const float* r) { return r[i] + (r[i + 1] - r[i]) * t; };
  return row(rows[0]) * (1 - mix) + row(rows[1]) * mix;
}

// Thin films. Sensitivity of the eye to a path difference, by the Fourier transform of the colour matching functions as
// sums of Gaussians (Belcour and Barla 2017, supplemental code, and the sample of KHR_materials_iridescence), as XYZ.
RGB sensitivity(float path, RGB shift) {
  const float phase = 2 * kPi * path * 1e-9f;
  constexpr float kValue[3] = {5.4856e-13f, 4.4201e-13f, 5.2481e-13f},
                  kPosition[3] = {1.6810e+06f, 1.7953e+06f, 2.2084e+06f},
                  kVariance[3] = {4.3278e+09f, 9.3046e+09f, 6.6121e+09f};
  RGB xyz;
  for (int c = 0; c < 3; ++c)
    xyz[c] = kValue[c] * std::sqrt(2 * kPi * kVariance[c]) * std::cos(kPosition[c] * phase + shift[c]) *
             std::exp(-phase * phase * kVariance[c]);
  xyz.r += 9.7470e-14f * std::sqrt(2 * kPi * 4.5282e+09f) * std::cos(2.2399e+06f * phase + shift.r) *
           std::exp(-4.5282e+09f * phase * phase);
  xyz = xyz / 1.0685e-7f;
  return {3.2404542f * xyz.r - 1.5371385f * xyz.g - 0.4985314f * xyz.b,
          -0.9692660f * xyz.r + 1.8760108f * xyz.g + 0.0415560f * xyz.b,
          0.0556434f * xyz.r - 0.2040259f * xyz.g + 1.0572252f * xyz.b};
}

}  // namespace

Sheen::Sheen(float alpha) : alpha_(std::clamp(alpha, kMinAlpha, 1.0f)) {
  const float x = std::sqrt(alpha_) * (kSheenAlphaNodes - 1);
  const int i = std::min(static_cast<int>(x), kSheenAlphaNodes - 2);
  mix_ = (alpha_ - node(i, kSheenAlphaNodes)) / (node(i + 1, kSheenAlphaNodes) - node(i, kSheenAlphaNodes));
  for (std::size_t n = 0; n < 2; ++n) {
    rows_[n] = tables().albedo[static_cast<std::size_t>(i) + n].data();
    rows_out_[n] = tables().out[static_cast<std::size_t>(i) + n].data();
  }
}

float Sheen::evaluate(Vec3 wo, Vec3 wi) const {
  const float most = std::max({1.0f, read_rows(rows_, mix_, wo.z), read_rows(rows_, mix_, wi.z)});
  return charlie(wo, wi, alpha_) / most;
}

float Sheen::albedo(float cosine) const { return std::min(1.0f, read_rows(rows_, mix_, cosine)); }

float Sheen::albedo_out(float cosine) const {
  return read_rows(rows_out_, mix_, cosine) / std::max(1.0f, read_rows(rows_, mix_, cosine));
}

RGB film_reflectance(float cosine, float eta, float thickness, RGB base) {
  const float sin2 = (1 - cosine * cosine) / (eta * eta);
  if (sin2 >= 1) return RGB(1.0f);
  const float inner = std::sqrt(1 - sin2);
  // Air to film, exact, so that a film of index 1 has no effect; a phase of pi if the film has the lower index.
  const float r12 = fresnel_dielectric(cosine, eta), t121 = 1 - r12;
  const float shift21 = eta < 1 ? 0 : kPi;
  RGB r23, shift;
  for (int c = 0; c < 3; ++c) {
    const float root = std::sqrt(std::clamp(base[c], 0.0f, 0.9999f));
    const float base_eta = (1 + root) / (1 - root);
    const float at_normal = (base_eta - eta) * (base_eta - eta) / ((base_eta + eta) * (base_eta + eta));
    r23[c] = at_normal + (1 - at_normal) * schlick_term(inner);
    shift[c] = shift21 + (base_eta < eta ? kPi : 0.0f);
  }
  const float path = 2 * eta * thickness * inner;
  const RGB r123 = clamp(r23 * r12, 1e-5f, 0.9999f), root = sqrt(r123);
  const RGB rs = r23 * (t121 * t121) / (RGB(1.0f) - r123);
  RGB sum = RGB(r12) + rs, order = rs - RGB(t121);
  for (int m = 1; m <= 2; ++m) {
    order *= root;
    const float times = static_cast<float>(m);
    sum += order * sensitivity(times * path, shift * times) * 2;
  }
  return clamp(sum, 0, 1);
}

}  // namespace glowworm::bsdf_detail
