#include "measure/isolines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "core/round_step.h"

namespace glowworm {

namespace {

/// An edge of the grid, by its first grid point and direction.
using Edge = std::pair<std::uint64_t, bool>;

class LevelLines {
 public:
  LevelLines(std::span<const float> values, int columns, float level)
      : values_(values), columns_(columns), rows_(static_cast<int>(values.size()) / columns), level_(level) {}

  std::vector<Isoline> trace() {
    for (int y = 0; y + 1 < rows_; ++y)
      for (int x = 0; x + 1 < columns_; ++x) add_cell(x, y);
    std::vector<Isoline> out;
    // Open lines first, from their ends.
    for (const bool closed : {false, true})
      for (auto& [edge, neighbours] : joins_)
        if (!neighbours.empty() && (closed || neighbours.size() == 1)) out.push_back(follow(edge));
    return out;
  }

 private:
  float at(int x, int y) const { return values_[static_cast<std::size_t>(y * columns_ + x)]; }

  Edge edge(int x, int y, bool down) const { return {static_cast<std::uint64_t>(y * columns_ + x), down}; }

  void join(Edge a, Edge b) {
    joins_[a].push_back(b);
    joins_[b].push_back(a);
  }

  void add_cell(int x, int y) {
    const bool corners[4] = {at(x, y) > level_, at(x + 1, y) > level_, at(x + 1, y + 1) > level_,
                             at(x, y + 1) > level_};
    const Edge sides[4] = {edge(x, y, false), edge(x + 1, y, true), edge(x, y + 1, false), edge(x, y, true)};
    std::vector<Edge> crossed;
    for (std::size_t i = 0; i < 4; ++i)
      if (corners[i] != corners[(i + 1) % 4]) crossed.push_back(sides[i]);
    if (crossed.size() == 2) join(crossed[0], crossed[1]);
    if (crossed.size() < 4) return;
    const float middle = (at(x, y) + at(x + 1, y) + at(x + 1, y + 1) + at(x, y + 1)) / 4;
    // The lines cut off the corners that differ from the middle.
    const bool cut_first = corners[0] != (middle > level_);
    join(sides[0], sides[cut_first ? 3 : 1]);
    join(sides[2], sides[cut_first ? 1 : 3]);
  }

  Vec2 point(const Edge& e) const {
    const int x = static_cast<int>(e.first) % columns_, y = static_cast<int>(e.first) / columns_;
    const float a = at(x, y), b = e.second ? at(x, y + 1) : at(x + 1, y), t = (level_ - a) / (b - a);
    return {static_cast<float>(x) + (e.second ? 0 : t), static_cast<float>(y) + (e.second ? t : 0)};
  }

  Isoline follow(Edge from) {
    Isoline line{level_, {point(from)}};
    for (;;) {
      std::vector<Edge>& ways = joins_[from];
      if (ways.empty()) return line;
      const Edge to = ways.back();
      ways.pop_back();
      std::vector<Edge>& back = joins_[to];
      back.erase(std::find(back.begin(), back.end(), from));
      line.points.push_back(point(to));
      from = to;
    }
  }

  std::span<const float> values_;
  int columns_, rows_;
  float level_;
  std::map<Edge, std::vector<Edge>> joins_;  // those that a line goes to from an edge, two at most
};

}  // namespace

std::vector<Isoline> isolines(std::span<const float> values, int columns, std::span<const float> levels) {
  std::vector<Isoline> out;
  for (const float level : levels) {
    std::vector<Isoline> lines = LevelLines(values, columns, level).trace();
    out.insert(out.end(), lines.begin(), lines.end());
  }
  return out;
}

std::vector<float> round_levels(std::span<const float> values, double least_step) {
  if (values.empty()) return {};
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  constexpr double kMostSteps = 8, kNearly = 1e-3;
  const double width = double{*most} - *least;
  if (!(width > kNearly * *most)) return {};
  const double step = round_step_above(std::max(width / kMostSteps, least_step));
  std::vector<float> out;
  for (double i = std::floor(*least / step) + 1; i * step < *most; ++i) out.push_back(static_cast<float>(i * step));
  return out;
}

}  // namespace glowworm
