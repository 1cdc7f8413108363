#include "measure/zones.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/offset_origin.h"
#include "core/text.h"

namespace glowworm {

namespace {

constexpr float kEyeHeight = 1.2f, kFloorReach = 1.5f;  // m

[[noreturn]] void refuse_zone(const std::string& text) {
  throw Error(fmt::format("--zone '{}' is no zone", text),
              "Write NAME=X,Y,Z,X,Y,Z[,SPACING] for a rectangle across an axis, by two opposite corners (m), or "
              "NAME=OBJECT[,SPACING] for the surface of an object.");
}

/// The greatest spacing of a grid by EN 12464-1, m. @param side the longer one, m
double standard_spacing(double side) { return std::min(0.2 * std::pow(5.0, std::log10(side)), 10.0); }

/// Height of the floor below a place, or infinity: of the lowest surface that faces up, or of a sheet that faces down.
float floor_below(const Tracer& tracer, Vec3 place) {
  float found = std::numeric_limits<float>::infinity();
  int inside = 0;  // solids that the ray has entered from above
  Ray ray{place, 0, {0, -1, 0}, kFloorReach};
  for (;;) {
    const Hit hit = tracer.intersect(ray);
    if (hit.triangle == kNone) return found;
    const float up = tracer.scene().diffuse_triangle(hit.triangle).normal.y;
    if (up > 0.5f || (up < -0.5f && inside == 0)) found = place.y - hit.distance;
    if (std::abs(up) > 0.5f) inside = up > 0 ? inside + 1 : std::max(inside - 1, 0);
    ray.t_min = std::nextafter(hit.distance + 2 * tracer.scene().diffuse_triangle(hit.triangle).offset(), HUGE_VALF);
    if (!(ray.t_min < ray.t_max)) return found;
  }
}

/// Centres of the cells of a rectangle.
template <typename Add>
void for_cells(const Zone& zone, int columns, int rows, Add&& add) {
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      add(zone.corner + zone.across * ((static_cast<float>(i) + 0.5f) / static_cast<float>(columns)) +
          zone.along * ((static_cast<float>(j) + 0.5f) / static_cast<float>(rows)));
}

/// Eyes on a grid of half the density, 1.2 m above the floor.
void add_eyes(Zone& zone, const Tracer& tracer, Sensors& sensors) {
  const Vec3 middle = zone.corner + (zone.across + zone.along) * 0.5f;
  const float ground = floor_below(tracer, middle);
  const float level = (std::isfinite(ground) ? ground : middle.y) + kEyeHeight;
  zone.first_eye = sensors.size();
  for_cells(zone, (zone.columns + 1) / 2, (zone.rows + 1) / 2, [&](Vec3 place) {
    place.y = level;
    for (std::size_t k = 0; k < kEyeDirections; ++k) {
      const auto turn = static_cast<float>(2 * M_PI * static_cast<double>(k) / kEyeDirections);
      sensors.add(place, {std::cos(turn), 0, std::sin(turn)});
    }
    ++zone.eyes;
  });
}

/// A rectangle of two corners in the coordinates of the tables.
Zone rectangle(const std::string& text, std::string name, Vec3 a, Vec3 b) {
  Zone zone;
  zone.name = std::move(name);
  int flat = -1;
  for (int axis = 0; axis < 3; ++axis)
    if (a[axis] == b[axis]) flat = flat < 0 ? axis : 3;
  if (flat < 0 || flat > 2) refuse_zone(text);
  zone.corner = a;
  if (flat == 1) {
    for (int axis = 0; axis < 3; ++axis) zone.corner[axis] = std::min(a[axis], b[axis]);
    zone.across = {std::abs(b.x - a.x), 0, 0};
    zone.along = {0, 0, std::abs(b.z - a.z)};
  } else {
    zone.across = b - a;
    zone.across.y = 0;
    zone.along = {0, b.y - a.y, 0};
  }
  return zone;
}

}  // namespace

Zone add_zone(const std::string& text, const Tracer& tracer, Sensors& sensors, std::size_t most, bool eyes) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse_zone(text);
  const std::string name = text.substr(0, equals), value = text.substr(equals + 1);
  const std::vector<double> v = numbers_of<double>(value);
  const Scene& scene = tracer.scene();
  if (v.empty()) {
    const bool spaced = value.find(',') != std::string::npos;
    const Sensors found = surface_sensors(spaced ? value : value + ",0.25", scene, most);
    Zone zone;
    zone.name = name;
    zone.first = sensors.size();
    zone.count = found.size();
    // Before the surface by more than rounding.
    constexpr float kBefore = 16;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Vec3 p = found.position[i], n = found.normal[i];
      sensors.add(p + n * (kBefore * position_rounding(p)), n, found.weight[i]);
    }
    return zone;
  }
  if ((v.size() != 6 && v.size() != 7) || (v.size() == 7 && !(v[6] > 0))) refuse_zone(text);
  const auto corner = [&](std::size_t i) {
    return scene.inside(scene.from_file_axes(Vec3d{v[i], v[i + 1], v[i + 2]}));
  };
  Zone zone = rectangle(text, name, corner(0), corner(3));
  const double width = length(zone.across), height = length(zone.along);
  const double spacing = v.size() == 7 ? v[6] : standard_spacing(std::max(width, height));
  const double columns = std::max(std::ceil(width / spacing - 1e-6), 1.0);
  const double rows = std::max(std::ceil(height / spacing - 1e-6), 1.0);
  // Eyes take at most kEyeDirections for each cell.
  if (columns * rows * (eyes ? 1 + kEyeDirections : 1) > static_cast<double>(most))
    throw Error(fmt::format("--zone '{}' takes {:.0f} sensors, for which memory has no room", text, columns * rows),
                "Give a larger spacing.");
  zone.columns = static_cast<int>(columns);
  zone.rows = static_cast<int>(rows);
  zone.first = sensors.size();
  zone.count = static_cast<std::size_t>(zone.columns) * static_cast<std::size_t>(zone.rows);
  const bool level = zone.along.y == 0;
  const Vec3 normal = level ? Vec3{0, 1, 0} : normalize(cross(zone.across, Vec3{0, 1, 0}));
  const auto area = static_cast<float>(width * height / (columns * rows));
  for_cells(zone, zone.columns, zone.rows, [&](Vec3 place) { sensors.add(place, normal, eyes ? 1 : area); });
  if (level && eyes) add_eyes(zone, tracer, sensors);
  return zone;
}

}  // namespace glowworm
