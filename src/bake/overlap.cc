#include "bake/overlap.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

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

  /// Calls visit(counts) for the row of cells, in each row, whose centres lie well inside of the face, either way it
  /// winds.
  template <typename Visit>
  void for_each_row(const std::array<Vec2, 3>& face, const Visit& visit) {
    constexpr double kInside = 1e-3;
    std::array<Vec2, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = (face[i] - low_) * scale_;
    double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
    if (!(std::abs(area) > 0)) return;
    if (area < 0) std::swap(p[1], p[2]);
    area = std::abs(area);
    const auto [y0, y1] = std::minmax({p[0].y, p[1].y, p[2].y});
    for (int y = static_cast<int>(y0); y <= std::min(static_cast<int>(y1), height_ - 1); ++y) {
      double first = 0.5, end = width_ + 0.5;  // centres
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec2 a = p[i], d = p[(i + 1) % 3] - a;
        // Inside: d.x (y + 0.5 - a.y) - d.y (x - a.x) > kInside area.
        const double left = d.x * (y + 0.5 - a.y) - kInside * area;
        if (d.y < 0) first = std::max(first, a.x + left / d.y);
        if (d.y > 0) end = std::min(end, a.x + left / d.y);
        if (d.y == 0 && !(left > 0)) end = 0;
      }
      if (!(first < end)) continue;
      const auto x0 = static_cast<int>(std::ceil(first - 0.5)), x1 = static_cast<int>(std::ceil(end - 0.5));
      if (x0 < x1)
        visit(std::span(count_).subspan(
            static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x0),
            static_cast<std::size_t>(x1 - x0)));
    }
  }

  const std::vector<std::uint8_t>& count() const { return count_; }

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
    grid.for_each_row(chart.corners[i], [&](std::span<std::uint8_t> row) {
      overlaps = overlaps || std::memchr(row.data(), 1, row.size()) != nullptr;
    });
    if (overlaps) {
      dropped.push_back(chart.faces[i]);
      continue;
    }
    grid.for_each_row(chart.corners[i], [](std::span<std::uint8_t> row) { std::memset(row.data(), 1, row.size()); });
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
    grid.for_each_row(face, [](std::span<std::uint8_t> row) {
      for (std::uint8_t& n : row) n = static_cast<std::uint8_t>(std::min(n + 1, 2));
    });
  std::size_t covered = 0, twice = 0;
  for (const std::uint8_t n : grid.count()) {
    covered += n > 0;
    twice += n > 1;
  }
  return covered > 0 ? static_cast<double>(twice) / static_cast<double>(covered) : 0;
}

}  // namespace glowworm
