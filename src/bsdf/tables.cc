#include "bsdf/tables.h"

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "bsdf/albedos.h"
#include "bsdf/fresnel.h"

namespace glowworm::bsdf_detail {
namespace {

// Numbers of nodes; brushed surfaces, of which there are more, have a coarser net.
constexpr int kAlphaNodes = 32, kEtaNodes = 17, kDepthNodes = 32;
constexpr int kBrushedAlphaNodes = 16, kRatioNodes = 6, kBrushedEtaNodes = 9;
constexpr int kBoundaries = static_cast<int>(Boundary::count);
constexpr float kMaxEta = 3, kMaxDepth = 4;

float node_cosine(int i) { return static_cast<float>(i * i) / ((kCosineNodes - 1) * (kCosineNodes - 1)); }
float node_alpha(int i, int nodes) { return static_cast<float>(i * i) / ((nodes - 1) * (nodes - 1)); }
float node_ratio(int i) { return static_cast<float>(i) / (kRatioNodes - 1); }
/// Nodes of the index are equidistant in the amplitude reflected at normal incidence.
float node_eta(int i, int nodes) {
  const float most = (kMaxEta - 1) / (kMaxEta + 1), s = most * i / (nodes - 1);
  return (1 + s) / (1 - s);
}

struct Split {
  int index;
  float fraction;
  float weight(int i) const { return i ? fraction : 1 - fraction; }
};
Split split(float x, int nodes) {
  x = std::clamp(x, 0.0f, static_cast<float>(nodes - 1));
  const int i = std::min(static_cast<int>(x), nodes - 2);
  return {i, x - i};
}
Split split_alpha(float alpha, int nodes) {
  return split(std::sqrt(std::clamp(alpha, 0.0f, 1.0f)) * (nodes - 1), nodes);
}
Split split_eta(float eta, int nodes) {
  const float most = (kMaxEta - 1) / (kMaxEta + 1);
  return split((eta - 1) / (eta + 1) / most * (nodes - 1), nodes);
}

bool is_brushed(const Microfacet& m) { return m.alpha_x != m.alpha_y; }

/// The rows of N functions at one node.
template <std::size_t N>
struct Cell {
  std::vector<float> rows;  ///< by function, Place::along if brushed, and cosine
  std::array<float, N> means;
  std::size_t row_size;

  /// @param integrate values of the functions at a Place
  template <class F>
  Cell(bool brushed, float ratio, F integrate) : row_size(brushed ? kAlongNodes * kCosineNodes : kCosineNodes) {
    rows.resize(N * row_size);
    for (std::size_t at = 0; at < row_size; ++at) {
      const auto along = static_cast<float>(at / kCosineNodes) / (kAlongNodes - 1);
      const std::array<float, N> values = integrate(Place{node_cosine(static_cast<int>(at % kCosineNodes)), along});
      for (std::size_t n = 0; n < N; ++n) rows[n * row_size + at] = values[n];
    }
    const auto weights = mean_weights_along(brushed ? ratio : 1);
    for (std::size_t n = 0; n < N; ++n) {
      means[n] = 0;
      for (std::size_t a = 0; a < row_size / kCosineNodes; ++a)
        means[n] += weights[a] * mean_over_cosines(row(n) + a * kCosineNodes);
    }
  }
  const float* row(std::size_t n) const { return &rows[n * row_size]; }

 private:
  /// Mean weighted by the cosine of a function that is linear between the nodes, as Curve reads it.
  static float mean_over_cosines(const float* row) {
    double sum = 0;
    for (int i = 0; i + 1 < kCosineNodes; ++i) {
      const double a = node_cosine(i), b = node_cosine(i + 1);
      sum += (b - a) / 3 * (row[i] * (2 * a + b) + row[i + 1] * (a + 2 * b));
    }
    return static_cast<float>(sum);
  }
};

/// Cells that are computed on first use: most scenes need a few.
template <std::size_t N, std::size_t Count>
class Cells {
 public:
  /// @param integrate as in Cell, if the cell is not there yet
  template <class F>
  const Cell<N>& get(std::size_t i, bool brushed, float ratio, F integrate) {
    std::call_once(made_[i], [&] { cells_[i] = std::make_unique<const Cell<N>>(brushed, ratio, integrate); });
    return *cells_[i];
  }

 private:
  std::array<std::unique_ptr<const Cell<N>>, Count> cells_;
  std::array<std::once_flag, Count> made_;
};

/// Calls f(alpha node, ratio node, weight) for the nodes around a surface.
template <class F>
void for_facets(const Microfacet& m, F f) {
  const float most = std::max(m.alpha_x, m.alpha_y);
  if (!is_brushed(m)) {
    const Split a = split_alpha(most, kAlphaNodes);
    for (int i = 0; i < 2; ++i) f(a.index + i, 0, a.weight(i));
    return;
  }
  const Split a = split_alpha(most, kBrushedAlphaNodes);
  const Split r = split(std::min(m.alpha_x, m.alpha_y) / most * (kRatioNodes - 1), kRatioNodes);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) f(a.index + i, r.index + j, a.weight(i) * r.weight(j));
}

/// The surfaces of nodes.
Facets plain_facets(int alpha) { return {node_alpha(alpha, kAlphaNodes)}; }
Facets brushed_facets(int alpha, int ratio) { return {node_alpha(alpha, kBrushedAlphaNodes), node_ratio(ratio)}; }
std::size_t brushed_index(int alpha, int ratio) { return static_cast<std::size_t>(alpha * kRatioNodes + ratio); }
constexpr std::size_t kBrushed = kBrushedAlphaNodes * kRatioNodes;

using BoundaryCell = Cell<kBoundaries>;
const BoundaryCell& boundary_cell(int alpha, int ratio, int eta, bool brushed) {
  if (brushed) {
    static Cells<kBoundaries, kBrushed * kBrushedEtaNodes> cells;
    const Facets facets = brushed_facets(alpha, ratio);
    const std::size_t i = static_cast<std::size_t>(eta) * kBrushed + brushed_index(alpha, ratio);
    return cells.get(i, true, facets.ratio,
                     [&](Place at) { return integrate_boundary(facets, at, node_eta(eta, kBrushedEtaNodes)); });
  }
  static Cells<kBoundaries, kAlphaNodes * kEtaNodes> cells;
  return cells.get(static_cast<std::size_t>(eta * kAlphaNodes + alpha), false, 1,
                   [&](Place at) { return integrate_boundary(plain_facets(alpha), at, node_eta(eta, kEtaNodes)); });
}

/// 1 - the mean Fresnel term over directions.
float mean_smooth_transmittance(float eta) {
  constexpr int n = 1024;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const float cosine = (i + 0.5f) / n;
    sum += 2 * cosine * (1 - fresnel_dielectric(cosine, eta)) / n;
  }
  return static_cast<float>(sum);
}

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

/// Tables of one index without roughness.
struct SmoothTable {
  std::array<float, kDepthNodes> absorption;
  float mean_transmittance;
};
const SmoothTable& smooth_table(int eta_node) {
  static std::array<SmoothTable, kEtaNodes> tables;
  static std::array<std::once_flag, kEtaNodes> made;
  std::call_once(made[eta_node], [&] {
    const float eta = node_eta(eta_node, kEtaNodes);
    tables[eta_node] = {integrate_absorption(eta), mean_smooth_transmittance(eta)};
  });
  return tables[eta_node];
}

using SchlickCell = Cell<5>;
/// The cell of an alpha that both axes have.
const SchlickCell& plain_schlick_cell(int alpha) {
  // All at once: checks of what is there would cost the most common materials time.
  static const std::vector<SchlickCell> cells = [] {
    std::vector<SchlickCell> out;
    for (int a = 0; a < kAlphaNodes; ++a)
      out.emplace_back(false, 1.0f, [a](Place at) { return integrate_schlick(plain_facets(a), at); });
    return out;
  }();
  return cells[alpha];
}
const SchlickCell& schlick_cell(int alpha, int ratio, bool brushed) {
  if (!brushed) return plain_schlick_cell(alpha);
  static Cells<5, kBrushed> cells;
  const Facets facets = brushed_facets(alpha, ratio);
  return cells.get(brushed_index(alpha, ratio), true, facets.ratio,
                   [&](Place at) { return integrate_schlick(facets, at); });
}

using FresnelCell = Cell<kFresnelNodes>;
const FresnelCell& fresnel_cell(int alpha, int ratio, bool brushed) {
  if (brushed) {
    static Cells<kFresnelNodes, kBrushed> cells;
    const Facets facets = brushed_facets(alpha, ratio);
    return cells.get(brushed_index(alpha, ratio), true, facets.ratio,
                     [&](Place at) { return integrate_fresnel(facets, at); });
  }
  static Cells<kFresnelNodes, kAlphaNodes> cells;
  return cells.get(static_cast<std::size_t>(alpha), false, 1,
                   [&](Place at) { return integrate_fresnel(plain_facets(alpha), at); });
}

}  // namespace

BoundaryTable::BoundaryTable(const Microfacet& m, float eta) : brushed_(is_brushed(m)) {
  const Split e = split_eta(eta, brushed_ ? kBrushedEtaNodes : kEtaNodes);
  const BoundaryCell* last = nullptr;
  for (int i = 0; i < 2; ++i)
    for_facets(m, [&](int alpha, int ratio, float weight) {
      weight *= e.weight(i);
      // Cells of weight 0 are not computed.
      if (weight > 0 || !last) last = &boundary_cell(alpha, ratio, e.index + i, brushed_);
      rows_[count_] = last->row(0);
      means_[count_] = last->means.data();
      weights_[count_++] = weight;
    });
  row_size_ = last->row_size;
}

float smooth_transmittance(float eta) {
  const Split e = split_eta(eta, kEtaNodes);
  return e.weight(0) * smooth_table(e.index).mean_transmittance +
         e.weight(1) * smooth_table(e.index + 1).mean_transmittance;
}

float internal_transmittance(float eta, float depth) {
  if (depth <= 0) return 1;
  if (depth >= kMaxDepth) return std::exp(-2 * depth);
  const Split e = split_eta(eta, kEtaNodes), d = split(std::cbrt(depth / kMaxDepth) * (kDepthNodes - 1), kDepthNodes);
  float sum = 0;
  for (int i = 0; i < 2; ++i) {
    const std::array<float, kDepthNodes>& row = smooth_table(e.index + i).absorption;
    sum += e.weight(i) * (row[d.index] + (row[d.index + 1] - row[d.index]) * d.fraction);
  }
  return std::exp(sum);
}

namespace {

/// Gives curves the rows of cells: cell(alpha node, ratio node) and n of its functions.
template <class GetCell>
void set_curves(const Microfacet& m, Curve* const* curves, std::size_t n, GetCell cell) {
  int count = 0;
  for_facets(m, [&](int alpha, int ratio, float weight) {
    const auto& found = cell(alpha, ratio, weight);
    for (std::size_t i = 0; i < n; ++i) {
      curves[i]->rows[count] = found.row(i);
      curves[i]->weights[count] = weight;
    }
    ++count;
  });
  for (std::size_t i = 0; i < n; ++i) {
    curves[i]->count = count;
    curves[i]->brushed = is_brushed(m);
  }
}

}  // namespace

SchlickCurves schlick_curves(const Microfacet& m) {
  SchlickCurves out;
  const bool brushed = is_brushed(m);
  Curve* const curves[] = {&out.scale, &out.bias, &out.scale_out, &out.bias_out};
  set_curves(m, curves, 4, [&](int alpha, int ratio, float weight) -> const SchlickCell& {
    const SchlickCell& cell = schlick_cell(alpha, ratio, brushed);
    out.mean_scale += weight * cell.means[0];
    out.mean_bias += weight * cell.means[1];
    return cell;
  });
  return out;
}

MirrorCurve mirror_curve(const Microfacet& m) {
  MirrorCurve out;
  out.all.brushed = is_brushed(m);
  for_facets(m, [&](int alpha, int ratio, float weight) {
    const SchlickCell& cell = schlick_cell(alpha, ratio, out.all.brushed);
    out.all.rows[out.all.count] = cell.row(4);
    out.all.weights[out.all.count++] = weight;
    out.mean += weight * cell.means[4];
  });
  return out;
}

FresnelCurves fresnel_curves(const Microfacet& m) {
  FresnelCurves out;
  const bool brushed = is_brushed(m);
  Curve* curves[kFresnelNodes];
  for (int i = 0; i < kFresnelNodes; ++i) curves[i] = &out.curve[i];
  set_curves(m, curves, kFresnelNodes,
             [&](int alpha, int ratio, float) -> const FresnelCell& { return fresnel_cell(alpha, ratio, brushed); });
  return out;
}

}  // namespace glowworm::bsdf_detail
