// Daylight of a year: the skies and suns of a weather file, times what sensors get of each patch of the sky and of the
// sun.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "control/job.h"
#include "import/weather.h"
#include "measure/matrix_file.h"
#include "measure/sensors.h"
#include "measure/sky_patches.h"
#include "measure/sun_grid.h"
#include "points/gather_points.h"
#include "scene/sky_model.h"

namespace glowworm {

/// Skies and suns of the hours of a weather file; visible light, W m^-2.
struct YearSky {
  std::vector<WeatherHour> hours;
  std::vector<std::uint32_t> lit;  ///< those with light, as indices into `hours`
  std::vector<Vec3> sun;           ///< of each of them: unit, towards the sun
  std::vector<float> beam;         ///< of each of them: normal irradiance of the sun; 0 while it is down
  ColorMatrix sky;                 ///< radiance of the ground and each patch (rows) in each of them, W sr^-1 m^-2
  std::vector<SkyModel> shape;  ///< the sky itself in each of them, with a black ground; empty: patches are known alone
};

/// The year by perez_sky(). Each patch has the mean radiance of its part of the sky; the ground that of its reflectance
/// times the horizontal irradiance of sky and sun over pi. The patches' horizontal irradiance is that of the sky.
YearSky year_sky(const WeatherYear& year, const SkyPatches& patches, double ground);

/// Radiance of the patches and the ground (reflectance `ground`) of the CIE overcast sky with a horizontal irradiance
/// of 1 W m^-2.
std::vector<float> overcast_sky(const SkyPatches& patches, double ground);

/// The sky of all hours (columns), as gendaymtx -s writes it.
ColorMatrix matrix_of_sky(const YearSky& sky);
/// Takes the sky from such a matrix. The suns stay those of the year. Throws Error if the size differs.
void replace_sky(YearSky& sky, const ColorMatrix& matrix, const std::string& path);

/// What sensors get: a row each.
struct DaylightCoefficients {
  ColorMatrix sky;   ///< daylight_matrix()
  ColorMatrix suns;  ///< sun_matrix() of coefficient_grid() and the places of a SunGrid: all other light of the sun
};

/// The sensors of a Job of coefficients: it leaves out the direct light of suns, which direct_sun() finds.
std::shared_ptr<const PointGrid> coefficient_grid(const Sensors& sensors, bool on_surfaces);

/// The mean of coefficients of several independent Jobs.
class CoefficientMean {
 public:
  CoefficientMean(const YearSky& sky, const SunGrid& grid);
  void add(const DaylightCoefficients& found);
  std::uint32_t count() const { return count_; }
  DaylightCoefficients mean() const;
  /// Of each sensor: standard error of the mean illuminance of an hour without the direct sun, over that illuminance,
  /// both as root mean squares over some hours; by student_factor(), so that the truth lies within twice of it with a
  /// chance of 95%. 0 for a single Job; infinite, which is unknown, where no Job found light.
  std::vector<float> relative_error() const;

 private:
  const YearSky& sky_;
  const SunGrid& grid_;
  std::vector<std::uint32_t> hours_;          // that errors are taken over, as indices into YearSky::lit
  std::vector<double> sum_, sum_of_squares_;  // of illuminances: hours of a sensor
  DaylightCoefficients total_;
  std::uint32_t count_ = 0;
};

/// Illuminance of sensors in some of the lit hours, without the direct sun; or luminance, of places whose coefficients
/// are of radiance.
class DiffuseLight {
 public:
  /// @param hours as indices into YearSky::lit
  DiffuseLight(const YearSky& sky, const SunGrid& grid, std::vector<std::uint32_t> hours);

  std::size_t size() const { return hours_.size(); }
  /// @param out one value an hour, lx
  void illuminance(const DaylightCoefficients& of, std::size_t sensor, std::span<float> out) const;

 private:
  const YearSky& sky_;
  const SunGrid& grid_;
  std::vector<std::uint32_t> hours_;
  // Channels of the sky in these hours, or one where it is grey: patches are rows, so that sums over hours run in
  // vectors.
  std::vector<std::vector<float>> channel_;
};

/// Which part of the sun's reflection reflected_sun() finds.
struct SunReflection {
  Lobes lobes = kBroad;
  float least_alpha = 0;  ///< GGX alpha to which narrower lobes are widened
};

/// What gather points reflect of the sun itself in some of the lit hours (columns), for a normal irradiance of 1:
/// luminance.
/// @param points in the order of their slots; points of one slot add up
/// @param slots rows of the result: points of other slots count for nothing
std::vector<float> reflected_sun(const Tracer& tracer, const GatherPoints& points, std::size_t slots,
                                 const YearSky& sky, std::span<const std::uint32_t> hours,
                                 const SunReflection& of = {});

/// What the sun gives sensors in the lit hours by flat smooth surfaces alone: cosine times the share that arrives,
/// times the luminance of a normal irradiance of 1. Sensors are rows.
struct DirectSun {
  std::vector<float> straight;  ///< from its own direction, through panes and solid glass
  /// From the directions of its images (LightImages); 0 for sensors on surfaces, which photons light.
  std::vector<float> mirrored;
};
/// @param progress is told the share that is done, by the calling thread, and 1 at the end; null: nobody is
DirectSun direct_sun(const Tracer& tracer, const PointGrid& grid, std::size_t sensors, const YearSky& sky,
                     const std::function<void(double)>& progress = nullptr);

/// Illuminance at sensors in all hours, lx.
struct Year {
  std::size_t sensors = 0, hours = 0;
  std::vector<float> total;  ///< a row of hours for each sensor
  std::vector<float> sun;    ///< of these DirectSun::straight, in the first of the states

  float at(std::size_t sensor, std::size_t hour) const { return total[sensor * hours + hour]; }
  static std::uint64_t bytes(std::size_t sensors, std::size_t hours) { return 2 * sizeof(float) * sensors * hours; }
};

/// A scene in one state of its shades.
struct YearState {
  DaylightCoefficients coefficients;
  DirectSun sun;  ///< direct_sun()
};

/// The lit hours of a state, as indices into YearSky::lit. @param state_of_hour as of year_of()
std::vector<std::uint32_t> hours_of_state(const YearSky& sky, std::span<const std::uint32_t> state_of_hour,
                                          std::size_t state);

/// Sums up a year. @param state_of_hour index into `states` of each hour of the file; empty: the first
Year year_of(const YearSky& sky, const SunGrid& grid, std::span<const YearState> states,
             std::span<const std::uint32_t> state_of_hour);

/// Illuminance of each sensor under `radiance` of the patches over that on an unobstructed horizontal plane, where that
/// is 1 W m^-2: daylight factors with overcast_sky().
std::vector<float> share_under(const DaylightCoefficients& coefficients, std::span<const float> radiance);

}  // namespace glowworm
