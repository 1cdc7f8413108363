// Daylight coefficients of a scene, found in rounds until their error is small enough.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "control/job.h"
#include "import/weather.h"
#include "measure/sensors.h"
#include "measure/sky_patches.h"
#include "measure/sun_grid.h"
#include "measure/year.h"

namespace glowworm {

/// The skies and suns of a weather file, and what they are taken apart into.
struct YearModel {
  SkyPatches patches;
  YearSky sky;
  SunGrid suns;
  double ground;  ///< reflectance of the ground outside

  /// @param patches 145 or 577 @param sun_step degrees between places of the sun. Throws Error, with the path, for a
  /// year without any light.
  YearModel(const WeatherYear& weather, const std::string& path, int patches, double ground, double sun_step);
};

/// A scene under one kind of light of a year.
struct YearScene {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;

  explicit YearScene(Scene lit);
};
/// Under the patches of the sky, and the ground.
YearScene under_sky(const Scene& plain, const YearModel& model);

/// The sensors of one scene in another, whose origin may differ.
Sensors moved_sensors(Sensors sensors, const Scene& from, const Scene& to);

/// Error of the illuminance of an hour at which rounds end: it holds within 5% with a chance of 95%.
inline constexpr double kYearNoise = 0.025;

/// Photons for each patch of the sky, and for each place of the sun, where their number is automatic: few of these blur
/// sunlight between slats.
inline constexpr std::uint64_t kPhotonsOfPatch = 2000, kPhotonsOfSun = 8000;

/// Throws MemoryError if the tables of a year and of the states of its scene take more than half of the budget.
void check_year_room(std::size_t sensors, std::size_t hours, std::size_t states, std::uint64_t memory_bytes);

/// Throws Error for settings that coefficients cannot be found with.
void check_year_settings(const RenderSettings& asked);

/// Which part of the work of find_state() a Job is.
struct YearProgress {
  double before = 0, share = 0;  ///< of all work, as far as is known
};
/// Divides work into parts whose number may change on the way. Progress never goes back.
class YearWork {
 public:
  /// The next part. Its end, `before + share`, is the `before` of the one that follows, bit for bit.
  /// @param left equal parts that are still expected, this one included
  YearProgress next(std::size_t left) {
    const YearProgress part{done_, (1 - done_) / static_cast<double>(left)};
    done_ = part.before + part.share;
    return part;
  }

 private:
  double done_ = 0;
};

/// Follows the work of a year.
struct YearWatch {
  std::function<void(Job&, YearProgress)> wait;  ///< waits for the end of a Job; throws its error
  /// Called with the share of all work that is done, while rays find the rest; exactly 1 at the end. May be null.
  std::function<void(double)> rays;
};

/// Coefficients of a scene.
struct FoundState {
  YearState state;
  std::vector<float> relative_error;  ///< of each sensor: CoefficientMean::relative_error()
  std::uint32_t rounds = 0;
  double seconds = 0;
};

/// Finds coefficients by rounds, which are independent: those of the sky by paths or photons, as plan_sensors()
/// chooses, and reflected sunlight by photons. Rounds end with the samples asked for, two a round, or once the root
/// mean square of the errors of sensors with weight is the noise asked for (kYearNoise if neither noise nor time is),
/// or the time has run out; there are two of them at least. Nothing if `watch` cancels a Job, of which a round has one
/// or two.
/// @param sky under_sky() of `plain` @param sensors in its coordinates
std::optional<FoundState> find_state(const Scene& plain, const YearScene& sky, const Sensors& sensors, bool on_surfaces,
                                     const YearModel& model, const RenderSettings& asked, const YearWatch& watch);

}  // namespace glowworm
