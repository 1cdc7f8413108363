#include "scene/default_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/box_tree.h"
#include "scene/placed_box.h"

namespace glowworm {

namespace {

constexpr std::array<Vec3, 6> kSides = {Vec3{0, 0, 1},  Vec3{1, 0, 0}, Vec3{0, 0, -1},
                                        Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}};
constexpr std::size_t kLevel = 4, kUp = 4;  ///< the first four are level

using Corners = std::array<Vec3, 3>;

enum class Side : std::uint8_t {
  open,
  wall,   ///< a surface that faces the origin of the ray
  solid,  ///< a surface that faces away
};

/// The boxes of instances.
std::vector<Box3> boxes_of_instances(const Geometry& geometry) {
  std::vector<Box3> meshes, out;
  for (const auto& mesh : geometry.meshes) meshes.push_back(mesh->bounds());
  for (const Instance& instance : geometry.instances)
    out.push_back(placed_box(instance.to_world, meshes[instance.mesh]));
  return out;
}

/// Calls use(corners) for the triangles that a ray may meet, in order. @param boxes boxes_of_instances()
template <typename Use>
void for_triangles_along(const Geometry& geometry, const std::vector<Box3>& boxes, Vec3 origin, Vec3 direction,
                         Use&& use) {
  for (std::uint32_t t = 0; t < geometry.triangles.size(); ++t) use(geometry.corners(t));
  const Vec3 inverse{1 / direction.x, 1 / direction.y, 1 / direction.z};
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (!meets_box(boxes[i], origin, inverse, std::numeric_limits<float>::infinity())) continue;
    const Geometry* mesh = geometry.meshes[geometry.instances[i].mesh].get();
    for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t)
      use(Geometry::corners({mesh, t, &geometry.instances[i]}));
  }
}

/// First hit of a ray from `origin` (Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997).
Side first_surface(const Geometry& geometry, const std::vector<Box3>& boxes, Vec3 origin, Vec3 direction) {
  float nearest = std::numeric_limits<float>::infinity();
  Side side = Side::open;
  for_triangles_along(geometry, boxes, origin, direction, [&](const Corners& corners) {
    const Vec3 p = corners[0], e1 = corners[1] - p, e2 = corners[2] - p;
    const Vec3 h = cross(direction, e2);
    const float determinant = dot(e1, h);
    if (determinant == 0) return;
    const Vec3 s = (origin - p) / determinant;
    const float u = dot(s, h);
    const Vec3 q = cross(s, e1);
    const float v = dot(direction, q), t = dot(e2, q);
    if (!(u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < nearest)) return;
    nearest = t;
    side = determinant > 0 ? Side::wall : Side::solid;
  });
  return side;
}

Vec3 half_extent(const Box3& box) { return box.diagonal() * 0.5f; }

Vec3 level_direction(int i, int count) {
  const float angle = 2 * kPi * static_cast<float>(i) / static_cast<float>(count);
  return {std::sin(angle), 0, std::cos(angle)};
}

/// The cells of a grid over the scene that contain surfaces. Rays through it are fast and approximate.
class CoarseScene {
 public:
  explicit CoarseScene(const Geometry& geometry) : box_(geometry.bounds()) {
    const Vec3 d = box_.diagonal();
    cell_ = std::max({d.x, d.y, d.z, std::numeric_limits<float>::min() * kCells}) / kCells;
    for (int i = 0; i < 3; ++i) size_[i] = std::clamp(static_cast<int>(d[i] / cell_) + 3, 3, kCells + 3);
    // Walls at the bounds get a whole cell, so that no step of a ray skips them.
    padded_ = {box_.min - Vec3{1, 1, 1} * cell_, box_.max + Vec3{1, 1, 1} * cell_};
    full_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], false);
    double points = 0;
    geometry.for_each_triangle([&](const Corners& corners) { points += std::pow(parts(corners), 2) / 2; });
    const double step = std::max(1.0, std::sqrt(points / kMaxPoints));
    geometry.for_each_triangle(
        [&](const Corners& corners) { fill(corners, std::max(1, static_cast<int>(parts(corners) / step))); });
  }
  float cell() const { return cell_; }
  const Box3& box() const { return box_; }

  /// Distance along a unit direction to a surface, at least `from`; infinity if the ray leaves the scene.
  float distance(Vec3 origin, Vec3 direction, float from) const {
    const float longest = length(box_.diagonal());
    for (float t = from; t <= longest; t += 0.7f * cell_) {
      const std::optional<std::size_t> cell = cell_of(origin + direction * t);
      if (!cell) break;
      if (full_[*cell]) return t;
    }
    return std::numeric_limits<float>::infinity();
  }

 private:
  static constexpr int kCells = 128;
  static constexpr double kMaxPoints = 5e7;

  int parts(const Corners& corners) const {
    const auto& [a, b, c] = corners;
    return 1 + static_cast<int>(std::max({length(b - a), length(c - b), length(a - c)}) / (0.6f * cell_));
  }
  void fill(const Corners& corners, int parts) {
    const Vec3 a = corners[0];
    const Vec3 x = (corners[1] - a) / static_cast<float>(parts);
    const Vec3 y = (corners[2] - a) / static_cast<float>(parts);
    for (int j = parts; j >= 0; --j)  // upwards, GCC 12 warns of an endless loop
      for (int i = parts - j; i >= 0; --i)
        if (const auto cell = cell_of(a + x * static_cast<float>(i) + y * static_cast<float>(j))) full_[*cell] = true;
  }
  std::optional<std::size_t> cell_of(Vec3 p) const {
    if (!padded_.contains(p)) return std::nullopt;
    int at[3];
    for (int i = 0; i < 3; ++i) at[i] = std::min(static_cast<int>((p[i] - padded_.min[i]) / cell_), size_[i] - 1);
    return (static_cast<std::size_t>(at[2]) * size_[1] + at[1]) * size_[0] + at[0];
  }

  Box3 box_, padded_;
  float cell_ = 1;
  int size_[3] = {1, 1, 1};
  std::vector<bool> full_;
};

/// Share of the triangles whose front is visible from around the scene, slightly above and below.
float visible_share(const Geometry& g, const CoarseScene& coarse) {
  constexpr std::size_t kMaxTriangles = 4000;
  const std::size_t stride = g.triangle_count() / kMaxTriangles + 1;
  std::size_t seen = 0, all = 0;
  for (std::size_t t = 0; t < g.triangle_count(); t += stride) {
    const auto [a, b, c] = g.corners(static_cast<std::uint32_t>(t));
    const Vec3 normal = g.normal(static_cast<std::uint32_t>(t));
    const Vec3 start = (a + b + c) / 3 + normal * (2 * coarse.cell());
    ++all;
    for (int i = 0; i < 16; ++i) {
      const Vec3 way = normalize(level_direction(i, 8) + Vec3{0, i < 8 ? 0.3f : -0.3f, 0});
      if (dot(way, normal) < 0.2f || std::isfinite(coarse.distance(start, way, 0))) continue;
      ++seen;
      break;
    }
  }
  return static_cast<float>(seen) / static_cast<float>(all);
}

/// The axis along which the scene is flat, apart from a slab on the ground, on which many objects stand; -1 if there is
/// none.
int flat_axis(const Box3& box) {
  const Vec3 half = half_extent(box);
  if (half.z < 0.2f * std::max(half.x, half.y)) return 2;
  if (half.x < 0.1f * std::max(half.y, half.z)) return 0;
  return half.y < 0.01f * std::max(half.x, half.z) ? 1 : -1;
}

struct Walls {
  std::size_t walls = 0, open = kSides.size();
};
Walls walls_around(const Geometry& geometry, Vec3 place) {
  Walls w;
  const std::vector<Box3> boxes = boxes_of_instances(geometry);
  for (std::size_t i = 0; i < kSides.size(); ++i) {
    const Side side = first_surface(geometry, boxes, place, kSides[i]);
    w.walls += side == Side::wall;
    if (side == Side::open) w.open = i;
  }
  return w;
}

float half_tangent(float degrees) { return std::tan(degrees / 2 * kPi / 180); }

/// Looks into the open side of a box whose other walls fill the rest of the picture.
Camera into_opening(const Box3& box, Vec3 side, float degrees) {
  constexpr float kMargin = 1.04f;
  const Vec3 half = half_extent(box);
  const float across = std::abs(side.x) > 0 ? half.z : half.x, depth = std::abs(side.x) > 0 ? half.x : half.z;
  const float distance = std::max(across, half.y) * kMargin / half_tangent(degrees);
  return look_at(box.center() + side * (depth + distance), box.center(), {0, 1, 0}, degrees);
}

/// Looks from a direction, at the distance at which all vertices are in the picture.
Camera from_outside(const Geometry& geometry, Vec3 direction, Vec3 up, float degrees) {
  constexpr float kMargin = 1.06f;
  const Vec3 center = geometry.bounds().center(), right = normalize(cross(up, direction));
  const Vec3 above = cross(direction, right);
  float distance = 0;
  geometry.for_each_position([&](const Vec3& p) {
    const Vec3 at = p - center;
    const float aside = std::max(std::abs(dot(at, right)), std::abs(dot(at, above)));
    distance = std::max(distance, aside * kMargin / half_tangent(degrees) + dot(at, direction));
  });
  return look_at(center + direction * (distance > 0 ? distance : 1.0f), center, up, degrees);
}

/// Looks straight at the side of a flat scene that has more area.
Camera at_panel(const Geometry& geometry, int axis, float degrees) {
  double facing = 0, area = 0;
  geometry.for_each_triangle([&](const Corners& corners) {
    const float along = cross(corners[1] - corners[0], corners[2] - corners[0])[axis];
    facing += along;
    area += std::abs(along);
  });
  Vec3 direction{0, 0, 0};
  direction[axis] = facing < -0.1 * area ? -1.0f : 1.0f;
  return from_outside(geometry, direction, axis == 1 ? Vec3{0, 0, -1} : Vec3{0, 1, 0}, degrees);
}

/// How much of the scene a view from inside sees, and how far: the mean square root of ray lengths.
float openness(const CoarseScene& coarse, Vec3 eye, Vec3 ahead, float tangent) {
  constexpr int kColumns = 9, kRows = 5;
  const float longest = length(coarse.box().diagonal()), nearest = 0.07f * longest;
  const Vec3 right = normalize(cross(ahead, {0, 1, 0})), up = cross(right, ahead);
  float sum = 0;
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i) {
      const float x = (2 * (static_cast<float>(i) + 0.5f) / kColumns - 1) * tangent;
      const float y = (2 * (static_cast<float>(j) + 0.5f) / kRows - 1) * tangent;
      const float d = coarse.distance(eye, normalize(ahead + right * x + up * y), 0);
      if (std::isfinite(d)) sum += d < nearest ? -0.3f : std::sqrt(d / longest);
    }
  return sum / (kColumns * kRows);
}

/// Whether a point is inside the scene, with surfaces below and on most sides, but none directly in front.
bool is_within(const CoarseScene& coarse, Vec3 place) {
  int hits = 0;
  if (!std::isfinite(coarse.distance(place, {0, -1, 0}, 0))) return false;
  for (int i = 0; i < 16; ++i) {
    const float d = coarse.distance(place, level_direction(i, 16), 0);
    if (d < 4 * coarse.cell()) return false;
    hits += std::isfinite(d);
  }
  return hits >= 10;
}

/// The most open view from inside; empty if no point is inside.
std::optional<Camera> within(const Geometry& geometry, const CoarseScene& coarse, float degrees) {
  constexpr int kPlaces = 11, kDirections = 16;
  struct View {
    float score;
    Vec3 eye, ahead;
  };
  std::vector<View> views;
  const Box3& box = coarse.box();
  const Vec3 d = box.diagonal();
  for (const float height : {0.22f, 0.35f, 0.5f})
    for (int i = 0; i < kPlaces * kPlaces; ++i) {
      const Vec3 eye = box.min + Vec3{d.x * (static_cast<float>(i % kPlaces) + 0.5f) / kPlaces, d.y * height,
                                      d.z * (static_cast<float>(i / kPlaces) + 0.5f) / kPlaces};
      if (!is_within(coarse, eye)) continue;
      View best{-1, eye, {}};
      for (int k = 0; k < kDirections; ++k) {
        const Vec3 ahead = normalize(level_direction(k, kDirections) + Vec3{0, 0.04f, 0});
        const float score = openness(coarse, eye, ahead, half_tangent(degrees));
        if (score > best.score) best = {score, eye, ahead};
      }
      views.push_back(best);
    }
  if (views.empty()) return std::nullopt;
  std::stable_sort(views.begin(), views.end(), [](const View& a, const View& b) { return a.score > b.score; });
  // The first one that is not inside a solid object, whose surfaces would face away.
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(views.size(), 8); ++i)
    if (walls_around(geometry, views[i].eye).walls >= 4) {
      chosen = i;
      break;
    }
  const View& view = views[chosen];
  return look_at(view.eye, view.eye + view.ahead * length(d), {0, 1, 0}, degrees);
}

/// The result of shape_of(), with the data behind it.
struct Looked {
  SceneShape shape = SceneShape::object;
  Walls walls;
  std::optional<CoarseScene> coarse;
};

Looked look(const Geometry& geometry) {
  constexpr float kHidden = 0.2f, kMostlyHidden = 0.35f;
  Looked out;
  const Box3 box = geometry.bounds();
  out.walls = walls_around(geometry, box.center());
  const std::size_t walls = out.walls.walls, open = out.walls.open;
  if (walls == kSides.size() - 1 && open < kLevel) {
    out.shape = SceneShape::box;
  } else if (flat_axis(box) >= 0) {
    out.shape = SceneShape::panel;
  } else {
    out.coarse.emplace(geometry);
    const float visible = visible_share(geometry, *out.coarse);
    const bool surrounded = walls == kSides.size() || (walls == kSides.size() - 1 && open == kUp);
    if (visible < (surrounded ? kMostlyHidden : kHidden)) out.shape = SceneShape::room;
  }
  return out;
}

}  // namespace

SceneShape shape_of(const Geometry& geometry) { return look(geometry).shape; }

void add_default_camera(SceneDescription& scene, float field_of_view) {
  if (!scene.cameras.empty() || scene.geometry.triangle_count() == 0) return;
  const Geometry& geometry = scene.geometry;
  const auto degrees = [&](float otherwise) { return field_of_view > 0 ? field_of_view : otherwise; };
  const Looked looked = look(geometry);
  std::optional<Camera> camera;
  if (looked.shape == SceneShape::room) camera = within(geometry, *looked.coarse, degrees(75));
  if (looked.shape == SceneShape::box) camera = into_opening(geometry.bounds(), kSides[looked.walls.open], degrees(40));
  if (looked.shape == SceneShape::panel) camera = at_panel(geometry, flat_axis(geometry.bounds()), degrees(45));
  if (!camera) camera = from_outside(geometry, normalize(Vec3{0.4f, 0.3f, 1}), {0, 1, 0}, degrees(45));
  camera->name = "default";
  scene.cameras.push_back(*camera);
  scene.notes.push_back("the scene has no camera; one was placed that sees it");
}

}  // namespace glowworm
