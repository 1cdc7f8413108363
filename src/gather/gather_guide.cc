#include "gather/gather_guide.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/box.h"

namespace glowworm {

namespace {

/// Regions have at least half as many points.
constexpr std::size_t kRegionPoints = 128;
/// Normals of a region whose components differ by more are divided, whatever their number.
constexpr float kNormalSpread = 0.5f;
constexpr std::size_t kMinPoints = 16;
/// Rays of the region around that count in the mean of a square of cells, and of a cell.
constexpr double kBorrowedRays = 8;
/// A region is guided if that lowers the variance to this share.
constexpr double kWorthwhile = 0.9;

float mixed(float a, float b, float t) { return a + (b - a) * t; }

/// The cell along a side in which integrals reach `sum`. @param sum_at(i) the integral up to the end of cell i
template <typename SumAt>
std::size_t cell_of(float sum, SumAt&& sum_at) {
  std::size_t cell = 0;
  for (std::size_t i = 0; i < GuideTable::kSide; ++i) cell += sum_at(i) <= sum;
  return std::min(cell, GuideTable::kSide - 1);
}

/// A place in a cell, from 0 to 1, and the density there.
struct Place {
  float at, density;
};

/// Where the integral of a density that goes from `low` to `high` over a cell reaches `sum`.
Place reach(float low, float high, float sum) {
  const float change = high - low, twice = 2 * sum;
  const float root = std::sqrt(std::max(low * low + change * twice, 0.0f));
  const float at = twice / (low + root);
  const float inside = at > 0 ? std::min(at, 1.0f) : 0;  // 0 / 0 where all is dark
  return {inside, low + change * inside};
}

/// The coordinate of a place in a cell.
float along_side(std::size_t cell, float at) {
  return std::min((static_cast<float>(cell) + at) / static_cast<float>(GuideTable::kSide), kBelowOne);
}

}  // namespace

float GuideTable::warp(float& x, float& y) const {
  const float row_sum = x * rows[kSide];
  const std::size_t r = cell_of(row_sum, [&](std::size_t end) { return rows[end + 1]; });
  const float s = reach(columns[r][kSide], columns[r + 1][kSide], row_sum - rows[r]).at;
  const auto mixed_at = [&](const float(&values)[kSide + 1][kSide + 1], std::size_t column) {
    return mixed(values[r][column], values[r + 1][column], s);
  };
  const float sum = y * mixed_at(columns, kSide);
  const std::size_t c = cell_of(sum, [&](std::size_t end) { return mixed_at(columns, end + 1); });
  const Place place = reach(mixed_at(density, c), mixed_at(density, c + 1), sum - mixed_at(columns, c));
  x = along_side(r, s);
  y = along_side(c, place.at);
  return 1 / place.density;
}

/// Divides the points, and makes the tables of leaves.
class GatherGuide::Learner {
 public:
  Learner(const GuideRays& rays, GatherGuide& out) : rays_(rays), out_(out), order_(rays.position.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    Box3 box;
    for (const Vec3& p : rays.position) box.grow(p);
    scale_ = 1 / std::max(length(box.diagonal()), std::numeric_limits<float>::min());
  }

  void learn() {
    Moments flat;
    const double rays = static_cast<double>(rays_.light.size());
    for (const float light : rays_.light) {
      flat.mean[0] += light / rays;
      flat.square[0] += static_cast<double>(light) * light / rays;
    }
    flat.mean.fill(flat.mean[0]);
    flat.square.fill(flat.square[0]);
    out_.nodes_.emplace_back();
    divide(0, order_, {flat, {{flat, flat}}});
  }

 private:
  /// Squares of cells along a side, and cells along the side of a square.
  static constexpr std::size_t kStrata = 8, kStep = kSide / kStrata;
  static constexpr std::size_t kSquares = kStrata * kStrata, kCellsOfSquare = kStep * kStep;

  using Cells = std::array<double, kCells>;
  using Squares = std::array<double, kSquares>;

  /// Of the light of rays in each cell.
  struct Moments {
    Cells mean{}, square{};
  };

  /// Moments of all points of a region, and of either half. A guide that one half teaches is tested on the other,
  /// because it fits the rays that it has learned from better.
  struct Knowledge {
    Moments all;
    std::array<Moments, 2> half;
  };

  float value(std::uint32_t point, int axis) const {
    return axis < 3 ? rays_.position[point][axis] : rays_.normal[point][axis - 3];
  }

  static std::size_t square_of(std::size_t cell) { return cell / kSide / kStep * kStrata + cell % kSide / kStep; }
  /// Sums over the cells of each square.
  static Squares by_squares(const Cells& cells) {
    Squares sums{};
    for (std::size_t i = 0; i < kCells; ++i) sums[square_of(i)] += cells[i];
    return sums;
  }
  static Squares means_of_squares(const Cells& cells) {
    Squares means = by_squares(cells);
    for (double& mean : means) mean /= kCellsOfSquare;
    return means;
  }
  /// Gives each cell the mean of its square.
  static Cells blurred(const Cells& cells) {
    const Squares means = means_of_squares(cells);
    Cells out;
    for (std::size_t i = 0; i < kCells; ++i) out[i] = means[square_of(i)];
    return out;
  }

  /// Turns sums into means. The mean of a square of cells is shrunk towards the mean in the region around. The mean of
  /// a cell is shrunk towards the share of its square that the cell has there, because few rays of a region meet each
  /// cell.
  static void find_means(Cells& sum, const Cells& around, const Cells& count) {
    const Squares own = by_squares(sum), rays = by_squares(count), before = means_of_squares(around);
    for (std::size_t i = 0; i < kCells; ++i) {
      const std::size_t q = square_of(i);
      const double mean = (own[q] + kBorrowedRays * before[q]) / (rays[q] + kBorrowedRays);
      const double expected = before[q] > 0 ? around[i] * mean / before[q] : 0;
      sum[i] = (sum[i] + kBorrowedRays * expected) / (count[i] + kBorrowedRays);
    }
  }

  /// @param counts whether a point does
  template <typename Counts>
  Moments moments(std::span<const std::uint32_t> points, const Moments& around, Counts&& counts) const {
    Cells count{};
    Moments m;
    for (const std::uint32_t p : points) {
      if (!counts(p)) continue;
      for (std::size_t i = std::size_t{p} * rays_.rays_each, end = i + rays_.rays_each; i < end; ++i) {
        const double light = rays_.light[i];
        count[rays_.cell[i]] += 1;
        m.mean[rays_.cell[i]] += light;
        m.square[rays_.cell[i]] += light * light;
      }
    }
    find_means(m.mean, around.mean, count);
    find_means(m.square, around.square, count);
    return m;
  }

  Knowledge knowledge(std::span<const std::uint32_t> points, const Knowledge& around) const {
    const auto in_half = [](std::uint32_t half) { return [half](std::uint32_t p) { return p / 2 % 2 == half; }; };
    return {moments(points, around.all, [](std::uint32_t) { return true; }),
            {moments(points, around.half[0], in_half(0)), moments(points, around.half[1], in_half(1))}};
  }

  void divide(std::uint32_t node, std::span<std::uint32_t> points, const Knowledge& around) {
    const Knowledge own = knowledge(points, around);
    int axis = -1;
    float split = 0;
    const auto middle = choose_split(points, axis, split);
    if (axis < 0) {
      out_.nodes_[node].first = add_table(own, static_cast<double>(points.size()) / static_cast<double>(order_.size()));
      return;
    }
    const auto first = static_cast<std::uint32_t>(out_.nodes_.size());
    out_.nodes_[node] = {axis, split, first, first + 1};
    out_.nodes_.resize(out_.nodes_.size() + 2);
    divide(first, points.first(middle), own);
    divide(first + 1, points.subspan(middle), own);
  }

  /// Orders the points around a split; returns the number of those below it. Leaves `axis` negative for a leaf.
  std::size_t choose_split(std::span<std::uint32_t> points, int& axis, float& split) const {
    float widest = 0, low = 0, high = 0;
    int along = -1;
    for (int a = 0; a < 6; ++a) {
      const auto less = [&](std::uint32_t x, std::uint32_t y) { return value(x, a) < value(y, a); };
      const auto [least, most] = std::minmax_element(points.begin(), points.end(), less);
      const float extent = (value(*most, a) - value(*least, a)) * (a < 3 ? scale_ : 1.0f);
      const bool counts =
          a < 3 ? points.size() >= kRegionPoints : extent > kNormalSpread && points.size() >= kMinPoints;
      if (!counts || !(extent > widest)) continue;
      widest = extent;
      along = a;
      low = value(*least, a);
      high = value(*most, a);
    }
    if (along < 0) return 0;
    if (along < 3) {
      const auto half = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
      std::nth_element(points.begin(), half, points.end(),
                       [&](std::uint32_t x, std::uint32_t y) { return value(x, along) < value(y, along); });
      split = value(*half, along);
    } else {
      split = (low + high) / 2;
    }
    const auto middle =
        std::partition(points.begin(), points.end(), [&](std::uint32_t p) { return value(p, along) < split; });
    const auto below = static_cast<std::size_t>(middle - points.begin());
    // Points of one coordinate cannot be divided.
    if (below > 0 && below < points.size()) axis = along;
    return below;
  }

  using Density = Cells;

  /// In proportion to the root mean square of the light, beside a share that is even.
  static Density density_of(const Moments& m, double even_share) {
    Density density;
    double sum = 0;
    for (std::size_t i = 0; i < kCells; ++i) sum += density[i] = std::sqrt(m.square[i]);
    for (double& d : density) d = sum > 0 ? even_share + (1 - even_share) * d * kCells / sum : 1;
    return density;
  }

  /// The rays of a pixel are stratified, as finely as squares of cells, so their variance is that within squares.
  static double variance(const Moments& m, const Density& density) {
    Cells weighted;
    for (std::size_t i = 0; i < kCells; ++i) weighted[i] = m.square[i] / density[i];
    const Squares square = by_squares(weighted), mean = by_squares(m.mean), rays = by_squares(density);
    double sum = 0;
    for (std::size_t q = 0; q < kSquares; ++q) sum += std::max(square[q] - mean[q] * mean[q] / rays[q], 0.0);
    return sum;
  }

  static Moments blurred(const Moments& m) { return {blurred(m.mean), blurred(m.square)}; }
  static Knowledge blurred(const Knowledge& known) {
    return {blurred(known.all), {blurred(known.half[0]), blurred(known.half[1])}};
  }

  /// Variance that guides learned from either half leave in the other, as a share of that without.
  /// @param learned what the guides learn from, of the rays of `known`
  static double variance_left(const Knowledge& known, const Knowledge& learned) {
    const auto with_share = [&](double even_share) {
      return variance(known.half[1], density_of(learned.half[0], even_share)) +
             variance(known.half[0], density_of(learned.half[1], even_share));
    };
    const double even = with_share(1);
    double least = kWorthwhile * even;
    bool gains = false;
    // The larger share of even rays is for light that few rays find: tables of half of the rays estimate it less well
    // than tables of all.
    for (const double even_share : {double{GatherGuide::kEvenShare}, 0.5})
      if (const double guided = with_share(even_share); guided < least) {
        least = guided;
        gains = true;
      }
    return gains ? least / even : 1;
  }

  /// Returns the index of the table, or kNone where it would not lower the variance enough. Its density is
  /// learned by cells or by squares of cells: few rays predict the light of squares better.
  /// @param points of the region, as a share of all
  std::uint32_t add_table(const Knowledge& known, double points) {
    const Knowledge squares = blurred(known);
    const double left_by_cells = variance_left(known, known), left_by_squares = variance_left(known, squares);
    const Density density = density_of(left_by_cells < left_by_squares ? known.all : squares.all, kEvenShare);
    if (!(variance(known.all, density) < kWorthwhile * variance(known.all, density_of(known.all, 1)))) return kNone;
    out_.gain_ += points * (1 - std::min(left_by_cells, left_by_squares));
    out_.tables_.push_back(table_of(density));
    return static_cast<std::uint32_t>(out_.tables_.size() - 1);
  }

  static GuideTable table_of(const Density& cells) {
    // A corner has the mean of the cells around it.
    constexpr int kCorners = kSide + 1;
    std::array<std::array<double, kCorners>, kCorners> density{}, columns{};
    std::array<double, kCorners> rows{};
    for (int r = 0; r < kCorners; ++r)
      for (int c = 0; c < kCorners; ++c) {
        for (const int row : {std::max(r - 1, 0), std::min(r, kSide - 1)})
          for (const int column : {std::max(c - 1, 0), std::min(c, kSide - 1)})
            density[r][c] += cells[static_cast<std::size_t>(row * kSide + column)] / 4;
        if (c > 0) columns[r][c] = columns[r][c - 1] + (density[r][c - 1] + density[r][c]) / 2;
      }
    for (int r = 1; r < kCorners; ++r) rows[r] = rows[r - 1] + (columns[r - 1][kSide] + columns[r][kSide]) / 2;
    const double scale = kCells / rows[kSide];
    GuideTable table;
    for (int r = 0; r < kCorners; ++r) {
      for (int c = 0; c < kCorners; ++c) {
        table.density[r][c] = static_cast<float>(density[r][c] * scale);
        table.columns[r][c] = static_cast<float>(columns[r][c] * scale);
      }
      table.rows[r] = static_cast<float>(rows[r] * scale);
    }
    return table;
  }

  const GuideRays& rays_;
  GatherGuide& out_;
  std::vector<std::uint32_t> order_;
  float scale_ = 1;
};

GatherGuide::GatherGuide(const GuideRays& rays) {
  if (!rays.position.empty()) Learner(rays, *this).learn();
}

std::uint32_t GatherGuide::region(Vec3 position, Vec3 normal) const {
  if (tables_.empty()) return kNone;
  std::uint32_t at = 0;
  while (nodes_[at].axis >= 0) {
    const Node& node = nodes_[at];
    const float value = node.axis < 3 ? position[node.axis] : normal[node.axis - 3];
    at = value < node.split ? node.first : node.other;
  }
  return nodes_[at].first;
}

void GatherGuide::warp(std::span<const std::uint32_t> regions, const DiffuseSquare& square, float* weight) const {
  for (std::size_t i = 0; i < regions.size(); ++i)
    if (regions[i] != kNone) weight[i] = tables_[regions[i]].warp(square.x[i], square.y[i]);
}

float GatherGuide::warp(std::uint32_t region, Vec2& u) const { return tables_[region].warp(u.x, u.y); }

float GatherGuide::density(std::uint32_t region, Vec2 u) const {
  const auto& corner = tables_[region].density;
  const float x = std::clamp(u.x, 0.0f, 1.0f) * kSide, y = std::clamp(u.y, 0.0f, 1.0f) * kSide;
  const int row = std::min(static_cast<int>(x), kSide - 1), column = std::min(static_cast<int>(y), kSide - 1);
  const float along = y - static_cast<float>(column);
  return std::lerp(std::lerp(corner[row][column], corner[row][column + 1], along),
                   std::lerp(corner[row + 1][column], corner[row + 1][column + 1], along), x - static_cast<float>(row));
}

std::uint8_t GatherGuide::cell(Vec2 u) {
  const auto along = [](float x) { return std::clamp(static_cast<int>(x * kSide), 0, kSide - 1); };
  return static_cast<std::uint8_t>(along(u.x) * kSide + along(u.y));
}

Frame GatherGuide::frame(Vec3 normal) {
  // No axis of the world, so that rounding of the normals of walls does not turn the frame.
  constexpr Vec3 kAxis{0.48f, 0.6f, 0.64f};
  const Vec3 s = cross(kAxis, normal);
  const float size = length(s);
  if (!(size > 1e-3f)) return Frame::from_normal(normal);
  return {s / size, cross(normal, s / size), normal};
}

}  // namespace glowworm
