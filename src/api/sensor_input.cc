#include "api/sensor_input.h"

#include <string>
#include <vector>

#include "api/checks.h"
#include "api/scene_implementation.h"
#include "core/error.h"

namespace glowworm::api {

namespace {

void check_outside(const Sensors& sensors, const glowworm::Tracer& tracer) {
  const std::vector<std::uint32_t> around = objects_around(sensors, tracer);
  for (std::size_t i = 0; i < around.size(); ++i)
    if (around[i] != kNone)
      throw Error("sensor " + std::to_string(i) + " is inside of the solid object \"" +
                      tracer.scene().geometry().objects[around[i]].name + "\"",
                  "Move it out: rays from it meet the back of that object's surface in all directions.");
}

}  // namespace

Sensors sensors_of(std::span<const Vec3> position, std::span<const Vec3> normal, const glowworm::Tracer& tracer,
                   bool on_surfaces) {
  check_lengths(normal.size(), position.size(), "normals", "sensors");
  if (position.empty()) throw Error("there are no sensors", "Give one or more.");
  check_finite(position, "sensor");
  check_unit(normal, "normal");
  Sensors sensors;
  for (std::size_t i = 0; i < position.size(); ++i)
    sensors.add(tracer.scene().inside(inner(position[i])), normalize(inner(normal[i])));
  if (!on_surfaces) check_outside(sensors, tracer);
  return sensors;
}

}  // namespace glowworm::api
