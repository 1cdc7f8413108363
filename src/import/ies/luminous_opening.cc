#include "import/ies/luminous_opening.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "scene/light_power.h"

namespace glowworm {

namespace {

/// Sides of a polygon in place of a circle, which has the circle's area.
constexpr int kSides = 24;
/// Splits of each edge of the octahedron in place of a sphere.
constexpr int kSplits = 4;

/// The faces of an opening in the axes of its luminaire: convex polygons, counter-clockwise seen from outside.
using Polygons = std::vector<std::vector<Vec3>>;

/// A vector of the axes (u, v, w), where w is axis `axis` and the others follow it.
Vec3 along(int axis, float u, float v, float w) {
  Vec3 out;
  out[(axis + 1) % 3] = u;
  out[(axis + 2) % 3] = v;
  out[axis] = w;
  return out;
}

/// A prism over a polygon of the plane across an axis; a single face, in the direction of the axis, where it has no
/// height.
Polygons prism(const std::vector<Vec2>& outline, int axis, float height) {
  Polygons faces;
  std::vector<Vec3> top, bottom;
  for (const Vec2 p : outline) top.push_back(along(axis, p.x, p.y, height / 2));
  faces.push_back(top);
  if (!(height > 0)) return faces;
  for (const Vec2 p : outline) bottom.push_back(along(axis, p.x, p.y, -height / 2));
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const std::size_t next = (i + 1) % outline.size();
    faces.push_back({bottom[i], bottom[next], top[next], top[i]});
  }
  std::reverse(bottom.begin(), bottom.end());
  faces.push_back(bottom);
  return faces;
}

/// A box; its shortest axis becomes the axis of the prism.
Polygons box(Vec3 size) {
  const int axis = size.z <= size.x && size.z <= size.y ? 2 : size.x <= size.y ? 0 : 1;
  const float u = size[(axis + 1) % 3] / 2, v = size[(axis + 2) % 3] / 2;
  return prism({{-u, -v}, {u, -v}, {u, v}, {-u, v}}, axis, size[axis]);
}

Polygons cylinder(Vec3 size, int axis) {
  const double turn = 2 * M_PI / kSides, grown = std::sqrt(turn / std::sin(turn));
  std::vector<Vec2> outline;
  for (int i = 0; i < kSides; ++i)
    outline.push_back({static_cast<float>(grown * size[(axis + 1) % 3] / 2 * std::cos((i + 0.5) * turn)),
                       static_cast<float>(grown * size[(axis + 2) % 3] / 2 * std::sin((i + 0.5) * turn))});
  return prism(outline, axis, size[axis]);
}

Vec3 scaled_normal(const std::vector<Vec3>& face) {
  Vec3 sum{0, 0, 0};
  for (std::size_t i = 1; i + 1 < face.size(); ++i) sum += cross(face[i] - face[0], face[i + 1] - face[0]) * 0.5f;
  return sum;
}

/// An octahedron whose faces are divided and moved onto the unit sphere, grown until it has the area of that.
Polygons ellipsoid(Vec3 size) {
  Polygons faces;
  double area = 0;
  for (int octant = 0; octant < 8; ++octant) {
    const Vec3 sign{octant & 1 ? -1.0f : 1.0f, octant & 2 ? -1.0f : 1.0f, octant & 4 ? -1.0f : 1.0f};
    const auto corner = [&](int i, int j) {
      const Vec3 p = normalize(Vec3{static_cast<float>(kSplits - i - j), static_cast<float>(i), static_cast<float>(j)});
      return Vec3{p.x * sign.x, p.y * sign.y, p.z * sign.z};
    };
    const bool mirrored = sign.x * sign.y * sign.z < 0;
    const auto add = [&](Vec3 a, Vec3 b, Vec3 c) {
      faces.push_back(mirrored ? std::vector<Vec3>{a, c, b} : std::vector<Vec3>{a, b, c});
      area += length(scaled_normal(faces.back()));
    };
    for (int i = 0; i < kSplits; ++i)
      for (int j = 0; i + j < kSplits; ++j) {
        add(corner(i, j), corner(i + 1, j), corner(i, j + 1));
        if (i + j + 1 < kSplits) add(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
      }
  }
  const auto grown = static_cast<float>(std::sqrt(4 * M_PI / area) / 2);
  for (std::vector<Vec3>& face : faces)
    for (Vec3& p : face) p = {p.x * size.x * grown, p.y * size.y * grown, p.z * size.z * grown};
  return faces;
}

Polygons faces_of(const LuminousOpening& opening) {
  switch (opening.shape) {
    case LuminousOpening::Shape::cylinder:
      return cylinder(opening.size, opening.axis);
    case LuminousOpening::Shape::ellipsoid:
      return ellipsoid(opening.size);
    case LuminousOpening::Shape::box:
      break;
  }
  return box(opening.size);
}

/// Whether a table has light on a side of a plane through the luminaire, but for rounding.
bool shines(const IntensityTable& table, Vec3 side) {
  constexpr int kSteps = 180;  // of a degree, and two
  const float least = 1e-5f * table.greatest();
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const auto polar = static_cast<float>((i + 0.5) * M_PI / kSteps),
                 turn = static_cast<float>(j * 2 * M_PI / kSteps);
      const Vec3 d{std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
      if (dot(d, side) > 0 && table.intensity(d) > least) return true;
    }
  return false;
}

/// Makes a single face shine to the sides where its luminaire has light. Returns whether these are both.
bool turn_to_light(Polygons& faces, const IntensityTable& table) {
  if (faces.size() > 1) return false;
  const Vec3 front = scaled_normal(faces[0]);
  const bool ahead = shines(table, front), behind = shines(table, -front);
  if (!ahead) std::reverse(faces[0].begin(), faces[0].end());
  return ahead && behind;
}

/// Distance by which flat openings lie in front of their place: one in the plane of a ceiling must be met before that,
/// whatever rounding does to distances within the scene.
float clearance(const SceneDescription& scene, Vec3 place) {
  constexpr float kRoundings = 0x1p-18f;
  Box3 box = scene.geometry.bounds();
  box.grow(place);
  float largest = 0;
  for (int axis = 0; axis < 3; ++axis) largest = std::max({largest, std::abs(box.min[axis]), std::abs(box.max[axis])});
  return kRoundings * largest;
}

Vec3 to_scene(const Light& light, Vec3 v) { return luminaire_axes(light.right, light.direction).to_world(v); }

/// @param light its direction and right side are unit and perpendicular
void add_opening(SceneDescription& scene, const Light& light, std::uint32_t material) {
  Polygons faces = faces_of(light.opening);
  Emission emission;
  emission.name = light.name;
  emission.two_sided = turn_to_light(faces, *light.table);
  emission.aim = light.direction;
  emission.right = light.right;
  Vec3 place = light.position;
  if (faces.size() == 1) place += normalize(to_scene(light, scaled_normal(faces[0]))) * clearance(scene, place);
  std::vector<Vec3> normals;
  double area = 0;
  Geometry mesh;
  for (const std::vector<Vec3>& face : faces) {
    normals.push_back(scaled_normal(face));
    area += length(normals.back());
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3 p : face) mesh.positions.push_back(place + to_scene(light, p));
    // The axes of a luminaire are left-handed.
    for (std::uint32_t i = 1; i + 1 < face.size(); ++i) mesh.triangles.push_back({first, first + i + 1, first + i});
  }
  mesh.normals.resize(mesh.positions.size());
  mesh.uvs.resize(mesh.positions.size());
  emission.profile = std::make_shared<const EmissionProfile>(light.table, std::move(normals), emission.two_sided);
  emission.radiance.value =
      light_power(light, 0) * static_cast<float>(1 / (M_PI * area * (emission.two_sided ? 2 : 1)));
  emission.first_triangle = static_cast<std::uint32_t>(scene.geometry.triangles.size());
  scene.geometry.begin_object(light.name);
  append_mesh(scene.geometry, mesh, light.name.c_str(), material, static_cast<std::uint32_t>(scene.emissions.size()));
  emission.triangle_count = static_cast<std::uint32_t>(scene.geometry.triangles.size()) - emission.first_triangle;
  scene.emissions.push_back(std::move(emission));
}

}  // namespace

LuminousOpening lm63_opening(float width, float length, float height, int edition) {
  const bool before_2002 = edition < 2002;
  if (before_2002 && height < 0 && width == 0 && length > 0) {
    width = height;  // a cylinder along the plane C0
  } else if (before_2002 && height < 0 && length == 0 && width > 0) {
    length = height;  // across it
  } else if ((width < 0 || length < 0) && (height >= 0 || before_2002)) {
    // Round from above.
    const bool has_both = width != 0 && length != 0;
    if (width == 0) width = length;
    if (length == 0) length = width;
    width = -std::abs(width);
    length = -std::abs(length);
    if (edition < 1995 && has_both) height = -height;  // an ellipsoid
  }
  LuminousOpening out;
  out.size = {std::abs(length), std::abs(width), std::abs(height)};
  const int round = (length < 0) + (width < 0) + (height < 0);
  if (round == 3) {
    out.shape = LuminousOpening::Shape::ellipsoid;
  } else if (round == 2) {
    out.shape = LuminousOpening::Shape::cylinder;
    out.axis = !(length < 0) ? 0 : !(width < 0) ? 1 : 2;
  }
  return out;
}

void add_luminous_openings(SceneDescription& scene) {
  std::vector<Light> points;
  auto material = static_cast<std::uint32_t>(scene.materials.size());
  for (Light& light : scene.lights) {
    const bool is_luminaire = light.kind == LightKind::luminaire && light.table && light.table->integral() > 0;
    const int extent = is_luminaire ? light.opening.extent() : 0;
    if (extent == 1)
      scene.notes.push_back(fmt::format("the opening of '{}' has one size alone: it is a point", light.name));
    if (extent < 2) {
      points.push_back(std::move(light));
      continue;
    }
    if (material == scene.materials.size()) {
      Material opening;
      opening.name = "luminous opening";
      opening.kind = MaterialKind::interface;
      scene.materials.push_back(std::move(opening));
    }
    light.direction = normalize(light.direction);
    light.right = normalize(light.right - light.direction * dot(light.right, light.direction));
    add_opening(scene, light, material);
  }
  scene.lights = std::move(points);
}

}  // namespace glowworm
