#include "bake/texels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace glowworm {

namespace {

constexpr float kInset = 0.05f;  ///< texels between a point and the rim of its face, at most

struct Nearest {
  Vec2 point;
  float squared = 0;  ///< distance
};

Nearest nearest_on_segment(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 d = b - a;
  const float l = d.x * d.x + d.y * d.y;
  const float t = l > 0 ? std::clamp(((p.x - a.x) * d.x + (p.y - a.y) * d.y) / l, 0.0f, 1.0f) : 0;
  const Vec2 q = a + d * t;
  return {q, (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y)};
}

/// A face in texel coordinates.
struct FlatFace {
  std::array<Vec2, 3> p;
  float area;  ///< twice, with sign

  explicit FlatFace(const std::array<Vec2, 3>& corners) : p(corners) {
    area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
  }

  /// Weights of the second and third corner; the middle of the face where it has no area.
  Vec2 barycentric(Vec2 c) const {
    if (!(std::abs(area) > 1e-12f)) return {1 / 3.0f, 1 / 3.0f};
    const float u = ((c.x - p[0].x) * (p[2].y - p[0].y) - (c.y - p[0].y) * (p[2].x - p[0].x)) / area;
    const float v = ((p[1].x - p[0].x) * (c.y - p[0].y) - (p[1].y - p[0].y) * (c.x - p[0].x)) / area;
    return {u, v};
  }

  Nearest nearest(Vec2 c) const {
    const Vec2 b = barycentric(c);
    if (std::abs(area) > 1e-12f && b.x >= 0 && b.y >= 0 && b.x + b.y <= 1) return {c, 0};
    Nearest best = nearest_on_segment(c, p[0], p[1]);
    for (std::size_t i = 1; i < 3; ++i)
      if (const Nearest n = nearest_on_segment(c, p[i], p[(i + 1) % 3]); n.squared < best.squared) best = n;
    return best;
  }

  /// Whether the square of two texels a side around a point overlaps the face: by the axes that may part them.
  bool meets_square(Vec2 c) const {
    constexpr float kHalf = 1 - 1e-3f;
    for (std::size_t i = 0; i < 5; ++i) {
      const Vec2 edge = p[(i + 1) % 3] - p[i % 3];
      const Vec2 axis = i < 3 ? Vec2{-edge.y, edge.x} : i == 3 ? Vec2{1, 0} : Vec2{0, 1};
      const auto along = [&](Vec2 q) { return (q.x - c.x) * axis.x + (q.y - c.y) * axis.y; };
      const auto [low, high] = std::minmax({along(p[0]), along(p[1]), along(p[2])});
      const float reach = kHalf * (std::abs(axis.x) + std::abs(axis.y));
      if (low > reach || high < -reach) return false;
    }
    return true;
  }

  /// The point moved towards the middle of the face.
  Vec2 inset(Vec2 c) const {
    const Vec2 middle = (p[0] + p[1] + p[2]) * (1 / 3.0f), d = middle - c;
    const float l = std::sqrt(d.x * d.x + d.y * d.y);
    return l > 0 ? c + d * std::min(0.25f, kInset / l) : c;
  }
};

/// The texels of one chart.
class ChartTexels {
 public:
  ChartTexels(const Chart& chart, const ChartPlace& place, int side, TexelMap& map)
      : chart_(chart),
        place_(place),
        row0_(place.atlas * side + place.y0),
        map_(map),
        distance_(static_cast<std::size_t>(place.width) * static_cast<std::size_t>(place.height),
                  std::numeric_limits<float>::max()) {}

  void fill(std::uint32_t number) {
    for (int y = 0; y < place_.height; ++y)
      for (int x = 0; x < place_.width; ++x) map_.chart[map_.index(place_.x0 + x, row0_ + y)] = number;
    for (std::size_t i = 0; i < chart_.faces.size(); ++i) add(i);
  }

 private:
  void add(std::size_t i) {
    std::array<Vec2, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) corners[c] = place_.texel(chart_.corners[i][c]);
    const FlatFace face(corners);
    const auto [x_low, x_high] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
    const auto [y_low, y_high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    // The centre of a texel that is read lies less than one texel away, along each axis.
    const auto first = [](float low, int from) { return std::max(static_cast<int>(std::floor(low - 1.5f)) - from, 0); };
    const auto last = [](float high, int from, int count) {
      return std::min(static_cast<int>(std::ceil(high + 0.5f)) - from, count - 1);
    };
    for (int y = first(y_low, place_.y0); y <= last(y_high, place_.y0, place_.height); ++y)
      for (int x = first(x_low, place_.x0); x <= last(x_high, place_.x0, place_.width); ++x)
        consider(x, y, face, chart_.faces[i]);
  }

  void consider(int x, int y, const FlatFace& face, std::uint32_t number) {
    const Vec2 center{static_cast<float>(place_.x0 + x) + 0.5f, static_cast<float>(place_.y0 + y) + 0.5f};
    if (!face.meets_square(center)) return;
    const Nearest n = face.nearest(center);
    float& least =
        distance_[static_cast<std::size_t>(y) * static_cast<std::size_t>(place_.width) + static_cast<std::size_t>(x)];
    if (!(n.squared < least)) return;
    least = n.squared;
    const std::size_t at = map_.index(place_.x0 + x, row0_ + y);
    map_.face[at] = number;
    const Vec2 b = face.barycentric(face.inset(n.point));
    map_.barycentric[at] = {std::clamp(b.x, 0.0f, 1.0f), std::clamp(b.y, 0.0f, 1.0f - std::clamp(b.x, 0.0f, 1.0f))};
  }

  const Chart& chart_;
  const ChartPlace& place_;
  int row0_;
  TexelMap& map_;
  std::vector<float> distance_;  ///< squared, from the centre of each texel of the rectangle to its point
};

}  // namespace

std::size_t TexelMap::covered() const {
  return face.size() - static_cast<std::size_t>(std::count(face.begin(), face.end(), kNone));
}

TexelMap map_texels(std::span<const Chart> charts, const Atlas& atlas) {
  TexelMap map;
  map.width = atlas.side;
  map.height = atlas.side * atlas.count;
  const std::size_t texels = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
  map.face.assign(texels, kNone);
  map.chart.assign(texels, kNone);
  map.barycentric.assign(texels, Vec2{});
  // Charts share no texel.
  parallel_for(0, charts.size(), 16, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      ChartTexels(charts[i], atlas.places[i], atlas.side, map).fill(static_cast<std::uint32_t>(i));
  });
  return map;
}

}  // namespace glowworm
