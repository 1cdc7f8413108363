#include "references/spectral_scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "import/pbrt/spectrum.h"
#include "import/pbrt/spectrum_tables.h"

namespace glowworm {

namespace {

constexpr double kLast = kMatchingFirst + kMatchingStep * (kMatchingCount - 1);
constexpr double kFirstNode = 410, kLastNode = 690;  // nm; radiance is constant beyond
constexpr int kSteps = 40;
constexpr int kTableSize = 24;

using Triple = std::array<double, 3>;

/// What light of relative power 1 in row i of the tables adds to linear RGB, so that all rows add up to white.
const std::array<Triple, kMatchingCount>& row_weights() {
  static const auto weights = [] {
    std::array<Triple, kMatchingCount> out{};
    Triple white{};
    for (int i = 0; i < kMatchingCount; ++i) {
      const auto& m = kMatching[static_cast<std::size_t>(i)];
      const double d = kDaylight65[static_cast<std::size_t>(i)];
      const RGB c = rgb_from_xyz(d * m[0], d * m[1], d * m[2]);
      out[static_cast<std::size_t>(i)] = {c.r, c.g, c.b};
      for (std::size_t k = 0; k < 3; ++k) white[k] += out[static_cast<std::size_t>(i)][k];
    }
    for (Triple& row : out)
      for (std::size_t k = 0; k < 3; ++k) row[k] /= white[k];
    return out;
  }();
  return weights;
}

double mapped(double wavelength) { return 2 * (wavelength - kMatchingFirst) / (kLast - kMatchingFirst) - 1; }

double sigmoid(double t) { return 0.5 + t / (2 * std::sqrt(1 + t * t)); }

/// RGB less the wanted colour, and how it changes with the three coefficients.
void residual_of(const SmoothSpectrum& spectrum, RGB wanted, Triple& residual, std::array<Triple, 3>& slope) {
  residual = {-wanted.r, -wanted.g, -wanted.b};
  slope = {};
  for (int i = 0; i < kMatchingCount; ++i) {
    const double x = mapped(kMatchingFirst + kMatchingStep * i);
    const double t = (spectrum.c[0] * x + spectrum.c[1]) * x + spectrum.c[2];
    const double value = sigmoid(t), change = 0.5 * std::pow(1 + t * t, -1.5);
    const Triple& weight = row_weights()[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < 3; ++k) {
      residual[k] += weight[k] * value;
      slope[k][0] += weight[k] * change * x * x;
      slope[k][1] += weight[k] * change * x;
      slope[k][2] += weight[k] * change;
    }
  }
}

double squared(const Triple& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

/// The step that least squares with a little damping asks for.
Triple step_of(const Triple& residual, const std::array<Triple, 3>& slope, double damping) {
  std::array<std::array<double, 4>, 3> m{};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t b = 0; b < 3; ++b) m[a][b] += slope[k][a] * slope[k][b];
      m[a][3] -= slope[k][a] * residual[k];
    }
    m[a][a] = m[a][a] * (1 + damping) + 1e-15;
  }
  for (std::size_t p = 0; p < 3; ++p)
    for (std::size_t row = 0; row < 3; ++row) {
      if (row == p) continue;
      const double factor = m[row][p] / m[p][p];
      for (std::size_t k = p; k < 4; ++k) m[row][k] -= factor * m[p][k];
    }
  return {m[0][3] / m[0][0], m[1][3] / m[1][1], m[2][3] / m[2][2]};
}

/// Smooth spectra of colours with largest component 1 or less, on a grid, at three wavelengths.
class SpectralTable {
 public:
  explicit SpectralTable(const std::array<double, 3>& wavelengths) {
    for (const SmoothSpectrum& s : spectra())
      values_.push_back({static_cast<float>(s.at(wavelengths[0])), static_cast<float>(s.at(wavelengths[1])),
                         static_cast<float>(s.at(wavelengths[2]))});
  }

  /// Trilinear between the colours of the grid; greys are flat, as in pbrt-v4.
  RGB reflectance(RGB color) const {
    if (color.r == color.g && color.g == color.b) return color;  // flat
    std::array<int, 3> cell{};
    std::array<float, 3> t{};
    for (int k = 0; k < 3; ++k) {
      const float x = std::clamp(color[k], 0.0f, 1.0f) * (kTableSize - 1);
      const auto i = static_cast<std::size_t>(k);
      cell[i] = std::min(static_cast<int>(x), kTableSize - 2);
      t[i] = x - static_cast<float>(cell[i]);
    }
    RGB sum;
    for (int corner = 0; corner < 8; ++corner) {
      float weight = 1;
      std::size_t index = 0;
      for (int k = 0; k < 3; ++k) {
        const int up = corner >> k & 1;
        const auto i = static_cast<std::size_t>(k);
        weight *= up ? t[i] : 1 - t[i];
        index = index * kTableSize + static_cast<std::size_t>(cell[i] + up);
      }
      sum += values_[index] * weight;
    }
    return sum;
  }

  /// Of light, which may be of any strength.
  RGB light(RGB color) const {
    const float scale = 2 * max_component(color);
    return scale > 0 ? reflectance(color / scale) * scale : RGB(0.0f);
  }

 private:
  static const std::vector<SmoothSpectrum>& spectra() {
    static const std::vector<SmoothSpectrum> all = [] {
      std::vector<SmoothSpectrum> out;
      constexpr float kStep = 1.0f / (kTableSize - 1);
      for (int r = 0; r < kTableSize; ++r)
        for (int g = 0; g < kTableSize; ++g)
          for (int b = 0; b < kTableSize; ++b)
            out.push_back(smooth_spectrum(
                RGB(static_cast<float>(r) * kStep, static_cast<float>(g) * kStep, static_cast<float>(b) * kStep)));
      return out;
    }();
    return all;
  }

  std::vector<RGB> values_;
};

/// An image whose colours are spectra at three wavelengths.
class SpectralImage final : public TextureImage {
 public:
  SpectralImage(std::shared_ptr<const TextureImage> image, std::shared_ptr<const SpectralTable> table)
      : image_(std::move(image)), table_(std::move(table)) {}
  RGB color(Vec2 uv) const override { return table_->reflectance(image_->color(uv)); }
  float alpha(Vec2 uv) const override { return image_->alpha(uv); }
  bool has_alpha() const override { return image_->has_alpha(); }
  int width() const override { return image_->width(); }
  int height() const override { return image_->height(); }

 private:
  std::shared_ptr<const TextureImage> image_;
  std::shared_ptr<const SpectralTable> table_;
};

/// Nodes that colours of surfaces come from, with those under them.
void mark_colors(const std::vector<TextureNode>& textures, std::uint32_t node, std::vector<bool>& marked) {
  if (node == kNone || marked[node]) return;
  marked[node] = true;
  mark_colors(textures, textures[node].child_a, marked);
  mark_colors(textures, textures[node].child_b, marked);
}

}  // namespace

double SmoothSpectrum::at(double wavelength) const {
  const double x = mapped(wavelength);
  return sigmoid((c[0] * x + c[1]) * x + c[2]);
}

SmoothSpectrum smooth_spectrum(RGB color) {
  const RGB wanted = clamp(color, 0.002f, 0.998f);
  SmoothSpectrum best;
  const double grey = std::clamp<double>(mean(wanted), 0.01, 0.99);
  best.c[2] = (2 * grey - 1) / (2 * std::sqrt(grey * (1 - grey)));
  Triple residual;
  std::array<Triple, 3> slope;
  residual_of(best, wanted, residual, slope);
  double damping = 1e-3;
  for (int i = 0; i < kSteps && squared(residual) > 1e-14; ++i) {
    const Triple step = step_of(residual, slope, damping);
    SmoothSpectrum next = best;
    for (std::size_t k = 0; k < 3; ++k) next.c[k] = std::clamp(next.c[k] + step[k], -500.0, 500.0);
    Triple next_residual;
    std::array<Triple, 3> next_slope;
    residual_of(next, wanted, next_residual, next_slope);
    if (squared(next_residual) < squared(residual)) {
      best = next;
      residual = next_residual;
      slope = next_slope;
      damping = std::max(damping * 0.1, 1e-12);
    } else {
      damping *= 10;
    }
  }
  return best;
}

SpectralNodes spectral_nodes(int triples) {
  SpectralNodes nodes;
  const int count = 3 * triples;
  const double step = (kLastNode - kFirstNode) / (count - 1);
  nodes.weights.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) nodes.wavelengths.push_back(kFirstNode + step * i);
  for (int i = 0; i < kMatchingCount; ++i) {
    const double x = std::clamp((kMatchingFirst + kMatchingStep * i - kFirstNode) / step, 0.0, count - 1.0);
    const int below = std::min(static_cast<int>(x), count - 2);
    const Triple& row = row_weights()[static_cast<std::size_t>(i)];
    const RGB weight{static_cast<float>(row[0]), static_cast<float>(row[1]), static_cast<float>(row[2])};
    const auto up = static_cast<float>(x - below);
    nodes.weights[static_cast<std::size_t>(below)] += weight * (1 - up);
    nodes.weights[static_cast<std::size_t>(below) + 1] += weight * up;
  }
  return nodes;
}

SceneDescription at_wavelengths(SceneDescription scene, const std::array<double, 3>& wavelengths) {
  const auto table = std::make_shared<const SpectralTable>(wavelengths);
  std::vector<bool> colored(scene.textures.size(), false);
  for (Material& m : scene.materials) {
    mark_colors(scene.textures, m.reflectance.texture, colored);
    mark_colors(scene.textures, m.transmittance.texture, colored);
    m.eta = table->light(m.eta);
    m.k = table->light(m.k);
    if (m.reflectance.texture == kNone) m.reflectance.value = table->reflectance(m.reflectance.value);
    if (m.transmittance.texture == kNone) m.transmittance.value = table->reflectance(m.transmittance.value);
  }
  for (std::size_t i = 0; i < colored.size(); ++i) {
    TextureNode& node = scene.textures[i];
    if (!colored[i]) continue;
    if (node.kind == TextureKind::constant) node.value = table->reflectance(node.value);
    if (node.image) node.image = std::make_shared<SpectralImage>(node.image, table);
  }
  for (Emission& emission : scene.emissions) emission.radiance.value = table->light(emission.radiance.value);
  for (Light& light : scene.lights) light.intensity = table->light(light.intensity);
  if (scene.environment) {
    if (scene.environment->pixels.empty()) scene.environment->scale = table->light(scene.environment->scale);
    for (RGB& pixel : scene.environment->pixels) pixel = table->light(pixel);
  }
  return scene;
}

}  // namespace glowworm
