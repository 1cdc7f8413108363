// Results of sensors, and their file formats.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "control/job.h"
#include "film/film.h"
#include "measure/alpha_opic.h"
#include "measure/sensors.h"

namespace glowworm {

/// Irradiance at sensors.
struct Measurement {
  Sensors sensors;              ///< in the axes of the user's file, relative to the origin
  Vec3 origin{0, 0, 0};         ///< in the coordinates and axes of the user's file, metres
  bool z_up = false;            ///< whose z axis points up, instead of y
  std::vector<RGB> irradiance;  ///< W m^-2 in each channel
  /// Error of the luminance over itself: the truth lies within twice of it with a chance of 95%. Infinite, which is
  /// unknown, where no sample found light, unless the scene has none.
  std::vector<float> relative_error;
  std::uint32_t samples = 0;          ///< of each sensor
  std::vector<AlphaOpic> alpha_opic;  ///< W m^-2 (alpha_opic.h); empty unless asked for

  /// The place of a sensor in the user's file, metres.
  Vec3d place(std::size_t sensor) const { return Vec3d(sensors.position[sensor]) + Vec3d(origin); }
};

/// Gather rays of a sample of a sensor, and paths in their place, where their number is automatic: sensors are few, and
/// a pass of photons costs as much as many rays.
inline constexpr std::uint32_t kPathsOfSample = 256;

/// The settings of a Job over sensor_grid(). Light is not filtered. Photon passes converge. Numbers that are automatic
/// are those of kDefaultSamples and kPathsOfSample.
RenderSettings sensor_settings(RenderSettings settings);

/// Most sensors whose tables take half of the memory: the places as read, without those inside of objects, in the grid
/// and in the results, and the text of a file.
std::size_t most_sensors(std::uint64_t memory_bytes);

/// Leaves room for the tables of sensors. Throws MemoryError if there are more than most_sensors().
/// @param settings with a number of bytes
RenderSettings with_room_for(std::size_t sensors, RenderSettings settings);

/// The end of such a Job: after two passes at least, so that errors are known.
JobEnd end_of_sensors();

/// Factor on a standard error that is known with so many degrees of freedom, by which twice their product (1.96 times)
/// holds the truth with a chance of 95%: quantiles of Student's t over those of the normal distribution, exact for 1
/// and 2 degrees and to 0.2% for more (Abramowitz and Stegun, "Handbook of Mathematical Functions", 26.7.5).
double student_factor(std::uint32_t degrees);

/// Takes the sensors' cells out of a film of the scene that was rendered over sensor_grid().
/// @param batches of that grid; few of them know the standard error badly (student_factor())
Measurement measurement_of(const Sensors& sensors, const Film& film, const Scene& scene,
                           std::uint32_t batches = kSensorBatches);

/// Illuminance of an irradiance in lx, by kLuminousEfficacy.
float illuminance(RGB irradiance);

/// The text with blanks in place of line breaks.
std::string one_line(std::string text);

/// Text files of a measurement. `about` is told in comments, such as the command line.
/// Comma-separated values, with the header x,y,z,nx,ny,nz,E_W_m2,E_R,E_G,E_B,E_lx,relative_error; E_W_m2 is the mean of
/// the three channels. Lines that begin with # are comments. With alpha-opic irradiances, columns follow for the
/// melanopic equivalent daylight illuminance (lx) and the five irradiances, in each of these formats.
std::string measurement_csv(const Measurement& measured, const std::string& about);
/// One object: "about", "lumens_per_watt", and "points", a list of objects with the columns of the CSV as keys.
std::string measurement_json(const Measurement& measured, const std::string& about);
/// ASCII PLY: vertices with normals, E_W_m2, E_lx and relative_error.
std::string measurement_ply(const Measurement& measured, const std::string& about);
/// Legacy VTK: points as vertices with normals and the same scalars.
std::string measurement_vtk(const Measurement& measured, const std::string& about);

}  // namespace glowworm
