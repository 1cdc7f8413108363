// Irradiance and illuminance at points.
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "glowworm/render.h"
#include "glowworm/scene.h"

namespace glowworm::api {

/// Results of a measurement: arrays of one length, one entry for each sensor.
struct Measurement {
  std::vector<Rgb> irradiance;  ///< W m^-2: the sum of the next three
  std::vector<Rgb> direct, indirect,
      caustic;                     ///< by way of the light: from lights, from surfaces, through glass and by mirrors
  std::vector<float> illuminance;  ///< lx, by 179 lm/W
  /// Error of the illuminance over itself, half of 95% confidence. Infinite, which is unknown, where no sample found
  /// light, unless the scene has none.
  std::vector<float> relative_error;
};

/// Options of measure().
struct MeasureOptions {
  /// Samples of each sensor, gather rays of each sample, photons, seed, noise and time. The size, crop, camera and AOVs
  /// of a picture are not used. Light is not filtered, and photons are new for every sample, so that the error is
  /// known. Integrator::gather without numbers of photons and gather rays stands for photons or paths, whichever take
  /// less work for the same error, as pilots find out.
  RenderOptions render;
  bool on_surfaces = false;  ///< the sensors lie on surfaces of the scene, so that photons show caustics there
};

/// Names for RenderOptions::more of measurements.
std::vector<std::string> measure_option_names();

/// Measures the light that arrives at points from the half space around their normals, as `glowworm measure` does.
/// @param position m sensors, metres
/// @param normal   m unit normals
/// Prints warnings on what is likely wrong, as the command does: a scene without light (which measures 0), lights and
/// sensors outside of a room.
/// @param progress as of render()
/// Throws Error for arrays of different lengths or none, numbers that are not finite, normals that are not unit, and
/// sensors inside of solid objects.
Measurement measure(const Scene& scene, std::span<const Vec3> position, std::span<const Vec3> normal,
                    const MeasureOptions& options = {}, const std::function<void(double)>& progress = {});

}  // namespace glowworm::api
