// Sensors named on the command line.
#pragma once
#include <string>
#include <vector>

#include "core/memory_budget.h"
#include "measure/sensors.h"
#include "measure/zones.h"
#include "trace/tracer.h"

namespace CLI {
class App;
}

namespace glowworm {

struct SensorOptions {
  std::string points, grid, surface;
  std::vector<std::string> zones;

  /// Whether one of them is given.
  bool are_given() const { return !points.empty() || !grid.empty() || !surface.empty() || !zones.empty(); }
  /// Throws CommandLineError unless one of them is given, and no other.
  void check() const;
  /// Whether the sensors lie on surfaces of the scene.
  bool on_surfaces() const { return !surface.empty(); }
};

/// Adds --points, --grid, --surface and --zone to a command.
void add_sensor_options(CLI::App& command, SensorOptions& options);
/// Adds --sky-patches. @param values placeholder in the help
void add_sky_patches_option(CLI::App& command, const std::string& group, int& patches, const std::string& values,
                            const std::string& meaning);

/// Reads or makes the sensors. Refuses sensors of a file that are inside of objects, and leaves out those of a plane;
/// those of zones keep their places, and count for nothing. Throws Error and CommandLineError for what is wrong with
/// them.
/// @param zones gets those of --zone @param eyes whether these have eyes
Sensors make_sensors(const SensorOptions& options, const Tracer& tracer, MemoryBudget& budget, std::vector<Zone>& zones,
                     bool eyes);

}  // namespace glowworm
