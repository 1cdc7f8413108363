// Light in space: a grid of probes with irradiance in spherical harmonics.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "film/film.h"
#include "gather/point_pass.h"
#include "image/image.h"
#include "trace/tracer.h"

namespace glowworm {

/// Probes at the corners of cubes that fill the scene's bounds.
struct ProbeGrid {
  Vec3d origin;                         ///< the first probe in the user's coordinates (Scene::outside()), metres
  float spacing = 0;                    ///< metres
  std::array<int, 3> counts{0, 0, 0};   ///< along x, y and z
  std::vector<Vec3> position;           ///< x runs fastest, then y
  std::vector<std::uint8_t> is_inside;  ///< of a solid object: no light is computed there
};

/// Most probes of a grid.
inline constexpr double kMaxProbes = 1e6;

/// A grid centred on the scene, half a spacing away from its bounds. Throws Error where it would have more than
/// kMaxProbes, or none.
ProbeGrid make_probes(const Scene& scene, const Tracer& tracer, float spacing);

/// Directions in which each probe measures irradiance: the axes and the diagonals of a cube.
inline constexpr int kProbeDirections = 14;

/// The points of a Job: a row for each probe, a column for each direction.
PointGrid probe_points(const ProbeGrid& probes);

/// Coefficients of irradiance (W m^-2) as a function of the normal: the sum over i of c_i Y_i(n), with Y_0 to Y_8 the
/// real orthonormal spherical harmonics up to degree 2 (Ramamoorthi and Hanrahan, "An Efficient Representation for
/// Irradiance Environment Maps", SIGGRAPH 2001), fitted by least squares.
using ProbeLight = std::array<RGB, 9>;
ProbeLight fit_probe(const std::array<RGB, kProbeDirections>& irradiance);

/// Value of irradiance for a unit normal.
RGB evaluate(const ProbeLight& light, Vec3 normal);

/// The grid and its light as a picture: a column for each x, a row for each z and y, of which y runs faster. Layer Yi
/// has coefficient i of fit_probe(), 0 inside of solid objects; the metadata have the grid as the JSON file has it.
/// @param irradiance of the cells of probe_points()
Image probes_image(const ProbeGrid& probes, const std::vector<RGB>& irradiance, const std::string& command_line);

/// The grid and its light as JSON. @param irradiance of the cells of probe_points()
std::string probes_json(const ProbeGrid& probes, const std::vector<RGB>& irradiance, const std::string& command_line);

}  // namespace glowworm
