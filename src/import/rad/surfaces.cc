#include "import/rad/surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "import/mesh_tools.h"
#include "import/pbrt/tessellation.h"
#include "import/polygon.h"

namespace glowworm {

namespace {

constexpr int kColumns = 128;  // around an axis

struct RadSurface {
  std::string_view type;
  std::size_t numbers;  ///< 0: three for each corner
  bool inward;
};
constexpr RadSurface kSurfaces[] = {{"polygon", 0, false}, {"sphere", 4, false}, {"bubble", 4, true},
                                    {"cone", 8, false},    {"cup", 8, true},     {"cylinder", 7, false},
                                    {"tube", 7, true},     {"ring", 8, false}};

const RadSurface* surface_of(const std::string& type) {
  const auto* const found =
      std::find_if(std::begin(kSurfaces), std::end(kSurfaces), [&](const RadSurface& s) { return s.type == type; });
  return found == std::end(kSurfaces) ? nullptr : found;
}

Vec3d point_of(const RadPrimitive& p, std::size_t first) {
  return {p.numbers[first], p.numbers[first + 1], p.numbers[first + 2]};
}

/// The factor on the radii that gives a frustum of kColumns flat sides the area of the round one.
double area_correction(double r0, double r1, double height) {
  const double half = M_PI / kColumns, sum = r0 + r1, apart = std::abs(r1 - r0);
  const double wanted = M_PI * sum * std::hypot(apart, height);
  double low = 1, high = 1 / std::cos(half);
  for (int i = 0; i < 60; ++i) {
    const double k = (low + high) / 2;
    const double area = kColumns * k * sum * std::sin(half) * std::hypot(k * apart * std::cos(half), height);
    (area < wanted ? low : high) = k;
  }
  return low;
}

/// The side between two circles around z, at z = 0 and at `height`, seen from outside; a ring seen from above if r0 is
/// the larger one.
Geometry frustum(double r0, double r1, double height) {
  const double k = area_correction(r0, r1, height), slant = std::hypot(height, r1 - r0);
  const double outward = slant > 0 ? height / slant : 0, upward = slant > 0 ? (r0 - r1) / slant : 1;
  Geometry mesh;
  for (int j = 0; j < 2; ++j) {
    const double r = k * (j == 0 ? r0 : r1), z = j == 0 ? 0 : height;
    for (int i = 0; i <= kColumns; ++i) {
      const double phi = 2 * M_PI * (i % kColumns) / kColumns, c = std::cos(phi), s = std::sin(phi);
      mesh.positions.push_back(narrow({r * c, r * s, z}));
      mesh.normals.push_back(narrow({outward * c, outward * s, upward}));
      mesh.uvs.push_back({static_cast<float>(i) / kColumns, static_cast<float>(j)});
    }
  }
  for (std::uint32_t i = 0; i < kColumns; ++i) {
    const std::uint32_t a = i, b = i + 1, c = kColumns + 1 + i, d = kColumns + 2 + i;
    if (r0 > 0) mesh.triangles.push_back({a, b, d});
    if (r1 > 0) mesh.triangles.push_back({a, d, c});
  }
  return mesh;
}

/// The map of a space with its z axis along `axis`. @param origin its origin
TransformDouble about_axis(Vec3d origin, Vec3d axis) {
  const Vec3d z = axis * (1 / length(axis));
  const Vec3d other = std::abs(z.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d across = cross(z, other), x = across * (1 / length(across));
  return {x, cross(z, x), z, origin};
}

void turn_over(Geometry& mesh) {
  reverse_winding(mesh);
  for (Vec3& n : mesh.normals) n = -n;
}

Geometry polygon_mesh(const RadPrimitive& p, const TransformDouble& to_world, CoordinateOrigin& origin,
                      NoteCounter& notes) {
  Geometry mesh;
  for (std::size_t i = 0; i < p.numbers.size(); i += 3) {
    const Vec3 place = origin.take(to_world.point(point_of(p, i)));
    if (mesh.positions.empty() || !(mesh.positions.back() == place)) mesh.positions.push_back(place);
  }
  while (mesh.positions.size() > 1 && mesh.positions.back() == mesh.positions.front()) mesh.positions.pop_back();
  mesh.normals.resize(mesh.positions.size());
  mesh.uvs.resize(mesh.positions.size());
  if (mesh.positions.size() >= 3 && !cut_polygon(mesh.positions, mesh.triangles))
    notes.add("polygon that crosses itself or has too many corners: cut as if convex");
  if (to_world.determinant() < 0) turn_over(mesh);
  return mesh;
}

/// A round surface in a space of its own, and the map from there.
std::pair<Geometry, TransformDouble> round_mesh(const RadPrimitive& p) {
  const auto radius = [&](std::size_t i) {
    if (p.numbers[i] < 0)
      throw Error(p.place, fmt::format("{} '{}' has a radius of {:g}", p.type, p.name, p.numbers[i]));
    return p.numbers[i];
  };
  if (p.type == "sphere" || p.type == "bubble") {
    const double r = p.numbers[3];
    if (r == 0) throw Error(p.place, fmt::format("{} '{}' has a radius of 0", p.type, p.name));
    Geometry mesh = tessellate_sphere(1, -1, 1, 2 * kPi, false).geometry;
    if (r < 0) turn_over(mesh);
    const double size = std::abs(r);
    return {std::move(mesh), {{size, 0, 0}, {0, size, 0}, {0, 0, size}, point_of(p, 0)}};
  }
  const bool ring = p.type == "ring", cylinder = p.type == "cylinder" || p.type == "tube";
  const Vec3d axis = ring ? point_of(p, 3) : point_of(p, 3) - point_of(p, 0);
  if (!(length(axis) > 0)) throw Error(p.place, fmt::format("{} '{}' has no axis", p.type, p.name));
  double r0 = radius(6), r1 = cylinder ? r0 : radius(7);
  if (ring && r0 < r1) std::swap(r0, r1);
  if (r0 + r1 == 0) throw Error(p.place, fmt::format("{} '{}' has a radius of 0", p.type, p.name));
  return {frustum(r0, r1, ring ? 0 : length(axis)), about_axis(point_of(p, 0), axis)};
}

}  // namespace

bool is_rad_surface(const std::string& type) { return surface_of(type) != nullptr; }

Geometry rad_surface(const RadPrimitive& p, const TransformDouble& to_world, bool inverted, CoordinateOrigin& origin,
                     NoteCounter& notes) {
  const RadSurface& surface = *surface_of(p.type);
  const bool is_polygon = surface.numbers == 0;
  if (is_polygon ? p.numbers.size() < 9 || p.numbers.size() % 3 != 0 : p.numbers.size() != surface.numbers)
    throw Error(p.place, fmt::format("{} '{}' has {} numbers", p.type, p.name, p.numbers.size()),
                is_polygon ? "Expected: three for each of three or more corners."
                           : fmt::format("Expected: {}.", surface.numbers));
  Geometry mesh;
  if (is_polygon) {
    mesh = polygon_mesh(p, to_world, origin, notes);
  } else {
    auto [shape, place] = round_mesh(p);
    mesh = std::move(shape);
    place_mesh(mesh, to_world * place, origin);
  }
  if (surface.inward != inverted) turn_over(mesh);
  return mesh;
}

}  // namespace glowworm
