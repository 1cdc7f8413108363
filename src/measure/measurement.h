// Results of sensors, and their file formats.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "measure/sensors.h"
#include "render/film.h"
#include "render/job.h"

namespace glowworm {

/// Irradiance at sensors.
struct Measurement {
  Sensors sensors;                    ///< in the user's coordinates (Scene::outside())
  std::vector<RGB> irradiance;        ///< W m^-2 in each channel
  std::vector<float> relative_error;  ///< standard error of the luminance over itself; 0 where no light is
};

/// The settings of a Job over sensor_grid(). Light is not filtered. Photon passes converge, and each has 256 gather
/// rays a sensor where their number is automatic, because sensors are few and a pass of photons costs as much as many
/// rays.
RenderSettings sensor_settings(RenderSettings settings);

/// Most sensors whose tables take half of the memory: the places as read, without those inside of objects, in the grid
/// and in the results, and the text of a file.
std::size_t most_sensors(std::uint64_t memory_bytes);

/// Leaves room for the tables of sensors. Throws MemoryError if there are more than most_sensors().
/// @param settings with a number of bytes
RenderSettings with_room_for(std::size_t sensors, RenderSettings settings);

/// Of such a Job: it makes two passes, so that errors are known.
JobTime sensor_time();

/// Takes the sensors' cells out of a film of the scene that was rendered over sensor_grid().
Measurement measurement_of(const Sensors& sensors, const Film& film, const Scene& scene);

/// Illuminance of an irradiance in lx, by kLuminousEfficacy.
float illuminance(RGB irradiance);

/// The text with blanks in place of line breaks.
std::string one_line(std::string text);

/// Text files of a measurement. `about` is told in comments, such as the command line.
/// Comma-separated values, with the header x,y,z,nx,ny,nz,E_W_m2,E_R,E_G,E_B,E_lx,relative_error; E_W_m2 is the mean of
/// the three channels. Lines that begin with # are comments.
std::string measurement_csv(const Measurement& measured, const std::string& about);
/// One object: "about", "lumens_per_watt", and "points", a list of objects with the columns of the CSV as keys.
std::string measurement_json(const Measurement& measured, const std::string& about);
/// ASCII PLY: vertices with normals, E_W_m2, E_lx and relative_error.
std::string measurement_ply(const Measurement& measured, const std::string& about);
/// Legacy VTK: points as vertices with normals and the same scalars.
std::string measurement_vtk(const Measurement& measured, const std::string& about);

}  // namespace glowworm
