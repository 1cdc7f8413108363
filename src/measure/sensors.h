// Places where light is measured: from a file, on a plane, or on the surfaces of an object.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "gather/point_pass.h"
#include "trace/tracer.h"

namespace glowworm {

/// Sensors, one after the other.
struct Sensors {
  std::vector<Vec3> position;  ///< metres, as the scene's tables have them (Scene::inside())
  std::vector<Vec3> normal;    ///< unit
  std::vector<float> weight;   ///< in means over sensors: m^2 of the surface around each, or 1

  static constexpr std::size_t kBytesEach = 2 * sizeof(Vec3) + sizeof(float);

  std::size_t size() const { return position.size(); }
  void reserve(std::size_t count) {
    position.reserve(count);
    normal.reserve(count);
    weight.reserve(count);
  }
  void add(Vec3 place, Vec3 direction, float sensor_weight = 1) {
    position.push_back(place);
    normal.push_back(direction);
    weight.push_back(sensor_weight);
  }
};

inline constexpr std::size_t kMaxSensors = 20'000'000;

/// Reads lines "x y z nx ny nz" (metres; a direction of any length), as Radiance's .pts files have them. Positions are
/// relative to the origin, and have the axes of the text (from_file_axes()), as it has. Blanks, tabs or commas
/// separate; empty lines and lines that begin with # are skipped. Throws Error with the line for others, for numbers
/// that are not finite and for directions of length 0, and MemoryError for more than `most`.
Sensors parse_points(std::string_view text, const std::string& path, Vec3 origin = {0, 0, 0},
                     std::size_t most = kMaxSensors);

/// Sensors in the axes of the user's file, as the scene's tables have them.
Sensors from_file_axes(Sensors sensors, const Scene& scene);

/// The middles of square cells of a plane within the scene's bounds. @param text "PLANE,SPACING", where PLANE is
/// x=V, y=V or z=V (m, in the axes of the user's file), and -x=V, ... for sensors that face the other way. Throws Error
/// for other texts, and where the plane misses the scene or has more than `most` cells.
Sensors plane_sensors(const std::string& text, const Scene& scene, std::size_t most = kMaxSensors);

/// Points on the front of the triangles of an object, cut into parts no longer than the spacing. @param text
/// "NAME,SPACING" (m). Throws Error, with the names, where there is no such object or it takes more than `most`.
Sensors surface_sensors(const std::string& text, const Scene& scene, std::size_t most = kMaxSensors);

/// PointGrid::batches of sensors. With more, their errors are known better, and are larger: a sequence of fewer samples
/// is less stratified.
inline constexpr std::uint32_t kSensorBatches = 8;

/// For each sensor the index of the object of the scene that it is inside of, or kNone. A sensor is taken to be inside
/// where rays in 14 directions all meet first the back of one object, or a surface at a side of its box that it stands
/// on. The box must be less than half as long as the scene's along every axis, so that no room is meant.
std::vector<std::uint32_t> objects_around(const Sensors& sensors, const Tracer& tracer);

/// The sensors as a grid to render: rows of kSensorsInRow at most, the last filled up by copies of the last sensor.
/// @param on_surfaces they lie on surfaces of the scene
/// @param batches     PointGrid::batches
PointGrid sensor_grid(const Sensors& sensors, bool on_surfaces, std::uint32_t batches = kSensorBatches);

}  // namespace glowworm
