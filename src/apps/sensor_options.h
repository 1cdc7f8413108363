// Sensors named on the command line.
#pragma once
#include <string>

#include "core/memory_budget.h"
#include "measure/sensors.h"
#include "trace/tracer.h"

namespace CLI {
class App;
}

namespace glowworm {

struct SensorOptions {
  std::string points, grid, surface;

  /// How many of them are given.
  int count() const { return int{!points.empty()} + int{!grid.empty()} + int{!surface.empty()}; }
  /// Throws CommandLineError unless one of them is given.
  void check() const;
  /// Whether the sensors lie on surfaces of the scene.
  bool on_surfaces() const { return !surface.empty(); }
};

/// Adds --points, --grid and --surface to a command.
void add_sensor_options(CLI::App& command, SensorOptions& options);

/// Reads or makes the sensors. Refuses sensors of a file that are inside of objects, and leaves out those of a plane.
/// Throws Error and CommandLineError for what is wrong with them.
Sensors make_sensors(const SensorOptions& options, const Tracer& tracer, MemoryBudget& budget);

}  // namespace glowworm
