#include "measure/lamp_glare.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/light_sampling.h"
#include "scene/surface.h"
#include "transport/light_connection.h"

namespace glowworm {

namespace {

/// Pieces are divided until their sides are at most this share of their distance, or this often.
constexpr float kLongestSide = 0.2f;
constexpr int kMostDivisions = 5;

class LampsInView {
 public:
  LampsInView(const Tracer& tracer, Vec3 eye, Vec3 view)
      : tracer_(tracer), eye_(eye), view_(view), right_(cross(view, {0, 1, 0})) {
    if (!tracer.scene().media().empty()) around_ = medium_at_start(tracer, eye, view);
  }

  /// A part of a triangle by barycentric coordinates.
  void add(std::uint32_t triangle, const std::array<Vec2, 3>& part, int divisions) {
    const DiffuseTriangle& t = tracer_.scene().diffuse_triangle(triangle);
    const auto place = [&](Vec2 w) { return t.corner + t.edge[0] * w.x + t.edge[1] * w.y; };
    const Vec3 a = place(part[0]), b = place(part[1]), c = place(part[2]);
    const float longest = std::max({length(b - a), length(c - b), length(a - c)});
    const float nearest = std::min({length(a - eye_), length(b - eye_), length(c - eye_)});
    if (divisions < kMostDivisions && longest > kLongestSide * nearest) {
      const auto middle = [](Vec2 p, Vec2 q) { return Vec2{(p.x + q.x) / 2, (p.y + q.y) / 2}; };
      const Vec2 ab = middle(part[0], part[1]), bc = middle(part[1], part[2]), ca = middle(part[2], part[0]);
      for (const std::array<Vec2, 3>& quarter :
           {std::array<Vec2, 3>{part[0], ab, ca}, {ab, part[1], bc}, {ca, bc, part[2]}, {bc, ca, ab}})
        add(triangle, quarter, divisions + 1);
      return;
    }
    add_piece(triangle, part, 0.5f * length(cross(b - a, c - a)));
  }

  std::vector<GlareSource> sources;

 private:
  void add_piece(std::uint32_t triangle, const std::array<Vec2, 3>& part, float area) {
    const Vec2 w{(part[0].x + part[1].x + part[2].x) / 3, (part[0].y + part[1].y + part[2].y) / 3};
    const SurfacePoint point = surface_point(tracer_.scene(), triangle, w);
    const Vec3 way = point.position - eye_;
    const float distance = length(way);
    const Vec3 direction = way / distance;
    GlareSource source;
    source.direction = {dot(direction, right_), direction.y, dot(direction, view_)};
    if (!(source.direction.z > 0)) return;
    const RGB radiance = emitted_radiance(tracer_.scene(), point, -direction);
    if (is_black(radiance)) return;
    constexpr float kBefore = 1 - 0x1p-16f;
    const RGB passed = passed_share(tracer_, {radiance,
                                              {eye_, 0, direction, distance * kBefore - point.offset},
                                              tracer_.scene().emissive_index(triangle),
                                              around_,
                                              {}});
    source.luminance = double{kLuminousEfficacy} * luminance(radiance * passed);
    if (!(source.luminance > 0)) return;
    source.solid_angle = area * std::abs(dot(direction, point.geometric_normal)) / (distance * distance);
    source.illuminance = source.luminance * source.solid_angle * source.direction.z;
    source.position_index = position_index(source.direction);
    sources.push_back(source);
  }

  const Tracer& tracer_;
  Vec3 eye_, view_, right_;
  PathMedium around_;
};

}  // namespace

std::vector<GlareSource> lamps_in_view(const Tracer& tracer, Vec3 eye, Vec3 view) {
  LampsInView lamps(tracer, eye, view);
  for (const std::uint32_t triangle : tracer.scene().emissive_triangles())
    lamps.add(triangle, {Vec2{0, 0}, Vec2{1, 0}, Vec2{0, 1}}, 0);
  return std::move(lamps.sources);
}

}  // namespace glowworm
