#include "measure/sensors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/error.h"
#include "core/lines.h"
#include "core/names.h"
#include "core/parallel.h"
#include "core/text.h"

namespace glowworm {

namespace {

constexpr std::size_t kSensorsInRow = 1024;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == ','; }

/// Reads finite numbers with blanks between them; the count, or more than `values` has room for, or 0 for another text.
std::size_t read_numbers(std::string_view line, std::array<double, 6>& values) {
  std::size_t count = 0;
  while (true) {
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    if (line.empty()) return count;
    double value = 0;
    if (!take_number(line, value) || !std::isfinite(static_cast<float>(value))) return 0;
    if (!line.empty() && !is_blank(line.front())) return 0;
    if (count < values.size()) values[count] = value;
    ++count;
  }
}

/// The number behind the last comma of a text, and what stands before it.
struct Spaced {
  std::string name;
  float spacing = 0;
};

Spaced read_spaced(const char* option, const std::string& text, const char* form) {
  const std::size_t comma = text.rfind(',');
  const bool named = comma != std::string::npos && comma > 0;
  const std::vector<float> spacing = named ? numbers_of<float>(text.substr(comma + 1)) : std::vector<float>();
  if (spacing.size() != 1 || !(spacing[0] > 0)) throw Error(fmt::format("{} '{}' has no spacing", option, text), form);
  return {text.substr(0, comma), spacing[0]};
}

/// @param most fewer than kMaxSensors: what memory has room for
void check_number(double count, const std::string& text, std::size_t most) {
  if (!(count <= static_cast<double>(most)))
    throw Error(fmt::format("'{}' makes {:.3g} sensors; {} are possible", text, count, most),
                most < kMaxSensors ? "Give a larger --memory or a larger spacing." : "Give a larger spacing.");
}

/// The directions to the corners and sides of a cube, turned askew so that they run along no surface.
std::array<Vec3, 14> directions_around() {
  std::array<Vec3, 14> out;
  std::size_t n = 0;
  for (int i = 0; i < 8; ++i) out[n++] = {i & 1 ? 1.0f : -1.0f, i & 2 ? 0.93f : -1.06f, i & 4 ? 1.04f : -0.96f};
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {1.0f, -1.0f}) {
      Vec3 d{0.05f, 0.03f, -0.04f};
      d[axis] = sign;
      out[n++] = d;
    }
  for (Vec3& d : out) d = normalize(d);
  return out;
}

/// The boxes of objects; empty for those that are half as long as the scene along an axis.
std::vector<Box3> boxes_of_small_objects(const Scene& scene) {
  const Geometry& g = scene.geometry();
  std::vector<Box3> boxes(g.objects.size());
  std::uint32_t t = 0;
  g.for_each_triangle([&](const std::array<Vec3, 3>& corners) {
    if (const std::uint32_t object = g.object_of(t++); object != kNone)
      for (const Vec3& corner : corners) boxes[object].grow(corner);
  });
  const Vec3 whole = scene.bounds().diagonal();
  for (Box3& box : boxes) {
    const Vec3 size = box.empty() ? whole : box.diagonal();
    if (!(size.x < 0.5f * whole.x && size.y < 0.5f * whole.y && size.z < 0.5f * whole.z)) box = Box3();
  }
  return boxes;
}

/// Whether a place lies on a side of a box.
bool is_on_side(const Box3& box, Vec3 place) {
  const float tolerance = 1e-3f * length(box.diagonal());
  bool within = true, on_side = false;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = place[axis] - box.min[axis], high = box.max[axis] - place[axis];
    within = within && low >= -tolerance && high >= -tolerance;
    on_side = on_side || std::abs(low) <= tolerance || std::abs(high) <= tolerance;
  }
  return within && on_side;
}

/// The small object around a place, or kNone.
std::uint32_t object_around(Vec3 place, std::span<const Vec3> directions, const std::vector<Box3>& small,
                            const Tracer& tracer) {
  const Geometry& g = tracer.scene().geometry();
  std::uint32_t around = kNone;
  std::vector<Vec3> others;
  for (const Vec3 d : directions) {
    Ray ray;
    ray.origin = place;
    ray.direction = d;
    ray.t_max = std::numeric_limits<float>::infinity();
    const Hit hit = tracer.intersect(ray);
    if (hit.triangle == kNone) return kNone;
    const std::uint32_t object = g.object_of(hit.triangle);
    const bool back = object != kNone && !small[object].empty() && dot(g.normal(hit.triangle), d) > 0;
    if (!back || (around != kNone && object != around))
      others.push_back(place + d * hit.distance);
    else
      around = object;
  }
  const bool stands = around != kNone &&
                      std::all_of(others.begin(), others.end(), [&](Vec3 p) { return is_on_side(small[around], p); });
  return stands ? around : kNone;
}

}  // namespace

Sensors parse_points(std::string_view text, const std::string& path, Vec3 origin, std::size_t most) {
  Sensors out;
  out.reserve(std::min(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1, most));
  int number = 0;
  text = without_byte_order_mark(text);
  while (!text.empty()) {
    std::string_view line = take_line(text);
    ++number;
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    if (line.empty() || line.front() == '#') continue;
    std::array<double, 6> v;
    if (read_numbers(line, v) != v.size())
      throw Error({path, number}, fmt::format("'{}' is not a place and a direction", line.substr(0, 80)),
                  "Write six finite numbers a line: x y z nx ny nz.");
    if (out.size() == most)
      throw Error({path, number}, fmt::format("there are more than {} sensors, for which memory has room", most),
                  "Give a larger --memory or fewer sensors.", ErrorCode::memory);
    const Vec3 normal = narrow({v[3], v[4], v[5]});
    const float l = length(normal);
    if (!(l > 0 && std::isfinite(l)))
      throw Error({path, number}, "the direction of the sensor has no length", "Give the normal that it faces along.");
    out.add(narrow(Vec3d{v[0], v[1], v[2]} - Vec3d(origin)), normalize(normal / l));
  }
  if (out.size() == 0) throw Error({path}, "holds no sensors", "Write six numbers a line: x y z nx ny nz.");
  return out;
}

Sensors from_file_axes(Sensors sensors, const Scene& scene) {
  for (Vec3& p : sensors.position) p = scene.from_file_axes(p);
  for (Vec3& n : sensors.normal) n = scene.from_file_axes(n);
  return sensors;
}

Sensors plane_sensors(const std::string& text, const Scene& scene, std::size_t most) {
  constexpr const char* kForm =
      "Write a plane and a spacing in metres, for example y=0.8,0.5, or -z=2,0.1 to face along -z.";
  const auto [plane, spacing] = read_spaced("--grid", text, kForm);
  const bool turned = plane.starts_with('-');
  const std::string_view rest = std::string_view(plane).substr(turned);
  const bool named = rest.size() > 2 && rest[0] >= 'x' && rest[0] <= 'z' && rest[1] == '=';
  const std::vector<double> levels = named ? numbers_of<double>(rest.substr(2)) : std::vector<double>();
  if (levels.size() != 1) throw Error(fmt::format("--grid '{}' names no plane", text), kForm);
  const int axis = rest[0] - 'x', across = axis == 0 ? 1 : 0, along = axis == 2 ? 1 : 2;
  // In the axes of the file, relative to the scene's origin.
  Box3 box;
  for (const Vec3 corner : {scene.bounds().min, scene.bounds().max}) box.grow(scene.to_file_axes(corner));
  const double origin = scene.to_file_axes(scene.origin())[axis];
  const auto level = static_cast<float>(levels[0] - origin);
  if (!(level >= box.min[axis] && level <= box.max[axis]))
    throw Error(fmt::format("the plane of --grid '{}' misses the scene, which reaches from {} to {} m", text,
                            coordinate_text(box.min[axis] + origin), coordinate_text(box.max[axis] + origin)));
  const Vec3 size = box.diagonal();
  const double columns = std::max(std::round(double{size[across]} / spacing), 1.0);
  const double rows = std::max(std::round(double{size[along]} / spacing), 1.0);
  check_number(columns * rows, text, most);
  Vec3 normal{0, 0, 0};
  normal[axis] = turned ? -1.0f : 1.0f;
  Sensors out;
  out.reserve(static_cast<std::size_t>(columns * rows));
  for (int j = 0; j < static_cast<int>(rows); ++j)
    for (int i = 0; i < static_cast<int>(columns); ++i) {
      Vec3 place;
      place[axis] = level;
      place[across] = static_cast<float>(box.min[across] + (i + 0.5) * size[across] / columns);
      place[along] = static_cast<float>(box.min[along] + (j + 0.5) * size[along] / rows);
      out.add(scene.from_file_axes(place), scene.from_file_axes(normal));
    }
  return out;
}

Sensors surface_sensors(const std::string& text, const Scene& scene, std::size_t most) {
  const auto [name, spacing] =
      read_spaced("--surface", text, "Write the name of an object and a spacing in metres, for example table,0.1.");
  const Geometry& g = scene.geometry();
  std::vector<std::string> names;
  for (const ObjectStart& object : g.objects) names.push_back(object.name);
  name_index("the object", name, names);
  Sensors out;
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
    const std::uint32_t object = g.object_of(t);
    if (object == kNone || g.objects[object].name != name || !(g.doubled_area(t) > 0) || scene.repeats(t)) continue;
    const auto [corner, second, third_corner] = g.corners(t);
    const Vec3 u = second - corner, v = third_corner - corner;
    const double longest = std::max({length(u), length(v), length(v - u)});
    const double parts = std::max(std::ceil(longest / spacing), 1.0);
    check_number(static_cast<double>(out.size()) + parts * parts, text, most);
    const int n = static_cast<int>(parts);
    const float area = g.area(t) / (static_cast<float>(n) * static_cast<float>(n));
    // Centres of gravity of n * n triangles alike, of which those beyond the diagonal of their square are turned.
    for (int y = 0; y < n; ++y)
      for (int x = 0; x + y < n; ++x)
        for (const float third : {1.0f / 3, 2.0f / 3})
          if (third < 0.5f || x + y + 1 < n)
            out.add(corner + u * ((static_cast<float>(x) + third) / static_cast<float>(n)) +
                        v * ((static_cast<float>(y) + third) / static_cast<float>(n)),
                    g.normal(t), area);
  }
  if (out.size() == 0) throw Error(fmt::format("the object \"{}\" has no surface", name));
  return out;
}

std::vector<std::uint32_t> objects_around(const Sensors& sensors, const Tracer& tracer) {
  const std::vector<Box3> small = boxes_of_small_objects(tracer.scene());
  const std::array<Vec3, 14> directions = directions_around();
  std::vector<std::uint32_t> out(sensors.size(), kNone);
  parallel_for(0, sensors.size(), 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) out[i] = object_around(sensors.position[i], directions, small, tracer);
  });
  return out;
}

PointGrid sensor_grid(const Sensors& sensors, bool on_surfaces, std::uint32_t batches) {
  PointGrid grid;
  const std::size_t rows = (sensors.size() + kSensorsInRow - 1) / kSensorsInRow;
  const std::size_t columns = (sensors.size() + rows - 1) / rows;
  grid.width = static_cast<int>(columns);
  grid.height = static_cast<int>(rows);
  grid.position = sensors.position;
  grid.normal = sensors.normal;
  grid.position.resize(columns * rows, sensors.position.back());
  grid.normal.resize(columns * rows, sensors.normal.back());
  grid.on_surfaces = on_surfaces;
  grid.learns = true;
  grid.batches = batches;
  return grid;
}

}  // namespace glowworm
