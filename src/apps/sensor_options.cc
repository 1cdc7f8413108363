#include "apps/sensor_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "apps/commands.h"
#include "apps/table_options.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"
#include "measure/measurement.h"

namespace glowworm {

namespace {

/// "12 and 4 more" of indices.
std::string list_of(const std::vector<std::size_t>& indices) {
  constexpr std::size_t kShown = 5;
  const std::vector<std::size_t> shown(indices.begin(),
                                       indices.begin() + static_cast<std::ptrdiff_t>(std::min(kShown, indices.size())));
  const std::string more = indices.size() > kShown ? fmt::format(" and {} more", indices.size() - kShown) : "";
  return fmt::format("{}{}", fmt::join(shown, ", "), more);
}

/// Refuses sensors of a file that are inside of objects; leaves out sensors of a plane that are.
void check_inside(const SensorOptions& o, Sensors& sensors, const Tracer& tracer) {
  if (o.on_surfaces()) return;
  const std::vector<std::uint32_t> around = objects_around(sensors, tracer);
  std::vector<std::size_t> inside;
  Sensors free;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (around[i] != kNone)
      inside.push_back(i);
    else
      free.add(sensors.position[i], sensors.normal[i], sensors.weight[i]);
  }
  if (inside.empty()) return;
  const std::string& object = tracer.scene().geometry().objects[around[inside.front()]].name;
  if (o.points.empty() && free.size() > 0) {
    inform(fmt::format("note: {} sensors inside of solid objects are left out", inside.size()));
    sensors = std::move(free);
    return;
  }
  throw Error(fmt::format("sensors are inside of solid objects, the first of \"{}\": {} (counted from 0)", object,
                          list_of(inside)),
              "Move them out: rays from them meet the back of that object's surface in all directions.");
}

Sensors sensors_of(const SensorOptions& o, const Scene& scene, MemoryBudget& budget) {
  Sensors sensors;
  if (!o.points.empty()) {
    Reservation held(budget, "the file of sensors", 0);
    const std::string text = read_input_file(o.points, held);
    const Vec3 origin = scene.to_file_axes(scene.origin());
    return from_file_axes(parse_points(text, o.points, origin, most_sensors(budget.available())), scene);
  }
  const std::size_t most = most_sensors(budget.limit());
  read_command_line(
      [&] { sensors = o.grid.empty() ? surface_sensors(o.surface, scene, most) : plane_sensors(o.grid, scene, most); });
  return sensors;
}

/// The sensors of zones. Those inside of objects count for nothing.
Sensors sensors_of_zones(const SensorOptions& o, const Tracer& tracer, const MemoryBudget& budget,
                         std::vector<Zone>& zones, bool eyes) {
  const std::size_t most = most_sensors(budget.limit());
  Sensors sensors;
  read_command_line([&] {
    for (const std::string& zone : o.zones)
      zones.push_back(add_zone(zone, tracer, sensors, most - sensors.size(), eyes));
  });
  const std::vector<std::uint32_t> objects = objects_around(sensors, tracer);
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (objects[i] != kNone) sensors.weight[i] = 0;
  for (const Zone& zone : zones)
    if (std::all_of(objects.begin() + static_cast<std::ptrdiff_t>(zone.first),
                    objects.begin() + static_cast<std::ptrdiff_t>(zone.first + zone.count),
                    [](std::uint32_t object) { return object != kNone; }))
      throw Error(fmt::format("all sensors of the zone '{}' are inside of solid objects", zone.name),
                  "Move the zone out of them.");
  return sensors;
}

}  // namespace

void SensorOptions::check() const {
  const int given = int{!points.empty()} + int{!grid.empty()} + int{!surface.empty()} + int{!zones.empty()};
  if (given != 1)
    throw CommandLineError(
        given == 0 ? "no sensors were given" : "sensors were given in more than one way",
        "Give one of --points FILE, --grid PLANE,SPACING, --surface NAME,SPACING and --zone NAME=...");
}

void add_sensor_options(CLI::App& command, SensorOptions& o) {
  add_text(command, "Sensors", "--points", o.points, "FILE",
           "Places and normals: a line x y z nx ny nz (m) for each sensor");
  add_text(command, "Sensors", "--grid", o.grid, "PLANE,SPACING",
           "Sensors on x=V, y=V or z=V (m) within the scene; -y=V: facing down");
  add_text(command, "Sensors", "--surface", o.surface, "NAME,SPACING", "Sensors on the front of an object's surface");
  add_list(command, "Sensors", "--zone", o.zones, "NAME=X,Y,Z,X,Y,Z|OBJECT[,SPACING]",
           "A zone: a rectangle by two opposite corners (m), with the spacing of EN 12464-1 unless another is given, "
           "or the front of an object's surface");
}

void add_sky_patches_option(CLI::App& command, const std::string& group, int& patches, const std::string& values,
                            const std::string& meaning) {
  command.add_option("--sky-patches", patches, meaning)
      ->check(CLI::IsMember({145, 577}))
      ->take_last()
      ->option_text(values)
      ->group(group);
}

Sensors make_sensors(const SensorOptions& o, const Tracer& tracer, MemoryBudget& budget, std::vector<Zone>& zones,
                     bool eyes) {
  if (!o.zones.empty()) return sensors_of_zones(o, tracer, budget, zones, eyes);
  Sensors sensors = sensors_of(o, tracer.scene(), budget);
  check_inside(o, sensors, tracer);
  return sensors;
}

}  // namespace glowworm
