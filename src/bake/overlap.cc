#include "bake/overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace glowworm {

namespace {

/// A grid of cells over a chart.
class CellGrid {
 public:
  CellGrid(const Chart& chart, int cells) {
    constexpr float kFar = std::numeric_limits<float>::max();
    Vec2 high{-kFar, -kFar};
    low_ = {kFar, kFar};
    for (const auto& face : chart.corners)
      for (const Vec2& p : face) {
        low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
      }
    const float side = std::max(high.x - low_.x, high.y - low_.y);
    scale_ = side > 0 ? static_cast<float>(cells) / side : 0;
    width_ = 1 + static_cast<int>((high.x - low_.x) * scale_);
    height_ = 1 + static_cast<int>((high.y - low_.y) * scale_);
    count_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  }

  /// Calls visit(cell) for every cell whose centre lies well inside of the face, either way it winds.
  template <typename Visit>
  void for_each_inside(const std::array<Vec2, 3>& face, const Visit& visit) const {
    constexpr float kInside = 1e-3f;
    std::array<Vec2, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = (face[i] - low_) * scale_;
    const float area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
    if (!(std::abs(area) > 0)) return;
    const auto [x0, x1] = std::minmax({p[0].x, p[1].x, p[2].x});
    const auto [y0, y1] = std::minmax({p[0].y, p[1].y, p[2].y});
    for (int y = static_cast<int>(y0); y <= std::min(static_cast<int>(y1), height_ - 1); ++y)
      for (int x = static_cast<int>(x0); x <= std::min(static_cast<int>(x1), width_ - 1); ++x) {
        const Vec2 c{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
        bool inside = true;
        for (std::size_t i = 0; i < 3; ++i) {
          const Vec2 a = p[i], b = p[(i + 1) % 3];
          inside = inside && ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / area > kInside;
        }
        if (inside) visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
      }
  }

  std::vector<std::uint8_t>& count() { return count_; }

 private:
  Vec2 low_;
  float scale_ = 0;
  int width_ = 0, height_ = 0;
  std::vector<std::uint8_t> count_;
};

}  // namespace

std::vector<std::uint32_t> drop_overlaps(Chart& chart) {
  std::vector<std::uint32_t> dropped;
  if (chart.faces.size() < 3) return dropped;
  CellGrid grid(chart, 256);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < chart.faces.size(); ++i) {
    bool overlaps = false;
    grid.for_each_inside(chart.corners[i], [&](std::size_t cell) { overlaps = overlaps || grid.count()[cell] > 0; });
    if (overlaps) {
      dropped.push_back(chart.faces[i]);
      continue;
    }
    grid.for_each_inside(chart.corners[i], [&](std::size_t cell) { grid.count()[cell] = 1; });
    chart.faces[kept] = chart.faces[i];
    chart.corners[kept++] = chart.corners[i];
  }
  chart.faces.resize(kept);
  chart.corners.resize(kept);
  return dropped;
}

double overlapping_share(const Chart& chart, int cells) {
  CellGrid grid(chart, cells);
  for (const auto& face : chart.corners)
    grid.for_each_inside(face, [&](std::size_t cell) {
      grid.count()[cell] = static_cast<std::uint8_t>(std::min(grid.count()[cell] + 1, 2));
    });
  std::size_t covered = 0, twice = 0;
  for (const std::uint8_t n : grid.count()) {
    covered += n > 0;
    twice += n > 1;
  }
  return covered > 0 ? static_cast<double>(twice) / static_cast<double>(covered) : 0;
}

}  // namespace glowworm
