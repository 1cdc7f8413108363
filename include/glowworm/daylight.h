// Daylight of a year at points, by a weather file.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "glowworm/render.h"
#include "glowworm/scene.h"

namespace glowworm::api {

/// Options of daylight() and annual_glare().
struct DaylightOptions {
  /// Seed, memory, samples (two a round), noise (0: 2.5%, or none with a time) and time of daylight(); seed, memory,
  /// photons and gather rays of annual_glare(). The rest has no effect.
  RenderOptions render;
  bool on_surfaces = false;  ///< the sensors lie on surfaces of the scene
  int sky_patches = 145;     ///< Tregenza's, or 577: Reinhart's
  double ground = 0.2;       ///< reflectance of the ground outside
  double sun_step = 7.5;     ///< degrees between places of the sun for its reflected light
  double turn = 0;           ///< degrees from -z to north, counter-clockwise seen from above

  std::string hours = "8-18";          ///< occupied hours of every day, FROM-TO in standard time
  std::vector<std::uint8_t> occupied;  ///< in place of them: 0 or 1 for each hour of the file
  /// Scenes in other states of their shades, and the state of each hour of the file: 0 for the scene itself, or n for
  /// the n-th of them. Both are empty, or none.
  std::vector<Scene> shades;
  std::vector<std::uint32_t> shade_of_hour;
  std::vector<float> area;  ///< m^2 around each sensor, for shares of the area; empty: all have the same

  double autonomy_lux = 300;                     ///< of daylight autonomy
  double sun_lux = 1000, sun_hours = 250;        ///< lx of the sun without any bounce, and hours of it, of ASE
  std::array<double, 3> useful{100, 300, 3000};  ///< lx: limits of useful daylight illuminance, rising
  double glare = 0.4;                            ///< simplified daylight glare probability from which hours count

  int view_pixels = 128;  ///< along a side of the pictures of annual_glare(), 16 to 1024
};

/// The daylight of a year. Shares are of the occupied hours, from 0 to 1; shares of sensors have one entry a sensor.
struct Daylight {
  struct Hour {
    std::int32_t month = 1, day = 1, hour = 1;  ///< the hour ends then, 1 to 24, standard time
  };
  std::vector<Hour> hours;         ///< of the weather file
  std::vector<float> illuminance;  ///< lx by 179 lm/W: a row of hours for each sensor
  std::vector<float> sun;          ///< the same of the sun without any bounce, in the scene without its shades

  std::vector<float> mean;             ///< lx over the occupied hours
  std::vector<float> autonomy;         ///< DA: share of hours with autonomy_lux or more
  std::vector<float> continuous;       ///< cDA: hours below it count by illuminance over it
  std::vector<float> useful;           ///< UDI: four for each sensor, below, supplementary, autonomous, exceeded
  std::vector<float> sun_hours;        ///< occupied hours with sun_lux or more
  std::vector<float> glare;            ///< share of hours with DaylightOptions::glare or more, of level normals
  std::vector<float> daylight_factor;  ///< 0 to 1, under the CIE overcast sky
  /// Error of the mean over hours over itself, without the direct sun: the truth lies within twice of it with a chance
  /// of 95%. Infinite where no light was found. The interpolation of reflected sunlight is not part of it.
  std::vector<float> relative_error;
  double spatial_autonomy = 0;  ///< sDA: share of the area with autonomy in half of the hours or more
  double sun_exposure = 0;      ///< ASE: share of the area with more than sun_hours
};

/// Glare of a view; 0 in hours without light.
struct ViewGlare {
  std::vector<float> dgp;          ///< daylight glare probability of each hour of the weather file
  std::vector<float> illuminance;  ///< lx on the plane across the view, in each hour
  /// Standard errors of both: the truth lies within twice the error with a chance of 95%. What the number of pixels and
  /// the sky's patches leave out is not part of them.
  std::vector<float> dgp_error, illuminance_error;
  double exceeded = 0;  ///< DGP that 5% of the occupied hours exceed (EN 17037:2018)
  std::size_t perceptible = 0, disturbing = 0, intolerable = 0;  ///< occupied hours with DGP above 0.35, 0.40, 0.45
};

/// The glare of a year.
struct AnnualGlare {
  std::vector<Daylight::Hour> hours;  ///< of the weather file
  std::vector<ViewGlare> views;
};

/// Names for RenderOptions::more of daylight() and annual_glare().
std::vector<std::string> daylight_option_names();

/// Finds the daylight of all hours of a weather file at points, as `glowworm daylight` does. The scene's own lights are
/// off.
/// @param weather path of a weather file of EnergyPlus (EPW)
/// @param position m sensors, metres @param normal m unit normals
/// @param progress as of render(); the share may fall, when rounds find that more of them are needed
/// Throws Error as measure() does, and for weather files and options that make no sense.
Daylight daylight(const Scene& scene, const std::string& weather, std::span<const Vec3> position,
                  std::span<const Vec3> normal, const DaylightOptions& options = {},
                  const std::function<void(double)>& progress = {});

/// Rates the glare of views in all hours of a weather file by their luminances, as `glowworm daylight --views` does.
/// The scene's own lights are off.
/// @param views fisheye or hemispherical, with a field of view of 180 degrees
/// @param options on_surfaces, area and the thresholds of sensors have no effect
/// @param progress as of daylight()
/// Throws Error as daylight() does, for other views, and where pictures take more than half of the memory.
AnnualGlare annual_glare(const Scene& scene, const std::string& weather, std::span<const Camera> views,
                         const DaylightOptions& options = {}, const std::function<void(double)>& progress = {});

}  // namespace glowworm::api
