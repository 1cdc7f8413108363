// How sensors are measured: by paths or by photons, and with how many, as pilot measurements find out.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "control/job.h"

namespace glowworm {

/// The relative error that plan_sensors() aims at where none is asked for.
inline constexpr double kSensorError = 0.02;

/// What plan_sensors() chose.
struct SensorPlan {
  RenderSettings settings;  ///< of the Job over the sensors: as sensor_settings() makes them
  std::string reason;       ///< a phrase for the terminal; empty: nothing was left to choose
  double seconds = 0;       ///< wall time of the pilots
  /// Passes that are finished, however long they take. Two make errors known. Paths are at least as many as those of
  /// the pilots, which may have used up the time: a few paths may all miss the light. Not where each has a photon map.
  std::uint32_t least_passes = 2;

  JobEnd end() const { return {seconds, nullptr, least_passes}; }
};

/// Chooses the integrator of sensors, Integrator::path or gather, and the samples, photons and gather rays that are not
/// asked for. Numbers of photons or gather rays, and another integrator, are taken as they are. A pilot traces paths
/// from a few sensors. If all the paths that the error takes are cheaper than a few photon maps, they measure.
/// Otherwise a second pilot gathers from the same sensors, and the measure with less work for the error wins. Gathered
/// light that differs from that of the paths by more than noise is biased, and never wins. Work is counted in rays and
/// photons: the choice depends neither on the machine nor on the number of threads. The measurement itself has other
/// random numbers than the pilots, so that its errors stay right.
/// @param wait waits for the end of a pilot; may cancel it
SensorPlan plan_sensors(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                        const PointGrid& grid, const RenderSettings& asked, const std::function<void(Job&)>& wait);

}  // namespace glowworm
