// What a year of daylight is rated by.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "measure/sensors.h"
#include "measure/year.h"

namespace glowworm {

/// Thresholds of the metrics.
struct MetricLimits {
  double autonomy = 300;        ///< lx, of daylight autonomy
  double autonomy_share = 0.5;  ///< of the occupied hours, of sDA
  double sun = 1000;            ///< lx of the sun without any bounce, of ASE
  double sun_hours = 250;       ///< of ASE
  /// lx: where useful daylight illuminance begins to supplement, to suffice, and to exceed (Mardaljevic et al.,
  /// "Daylighting metrics: is there a relation between useful daylight illuminance and daylight glare probability?",
  /// 2012)
  std::array<double, 3> useful{100, 300, 3000};
  double glare = 0.4;  ///< of simplified DGP: disturbing

  /// Whether `useful` rises from above 0.
  bool are_sound() const { return useful[0] > 0 && useful[0] < useful[1] && useful[1] < useful[2]; }
};

/// Metrics of a sensor over the occupied hours; shares of them, from 0 to 1.
struct SensorMetrics {
  double mean = 0;                 ///< lx
  double autonomy = 0;             ///< with MetricLimits::autonomy or more
  double continuous = 0;           ///< continuous daylight autonomy: hours below it count by illuminance over it
  std::array<double, 4> useful{};  ///< below, supplementary, autonomous, exceeded
  double sun_hours = 0;            ///< hours with MetricLimits::sun or more
  double glare = 0;                ///< hours with simplified_glare() of MetricLimits::glare or more
};

/// Metrics of an area.
struct ZoneMetrics {
  std::size_t sensors = 0;
  double spatial_autonomy = 0;  ///< sDA: share of the area whose sensors have MetricLimits::autonomy_share or more
  double sun_exposure = 0;      ///< ASE: share of the area with more than MetricLimits::sun_hours
  SensorMetrics mean;           ///< over the area
};

/// Simplified daylight glare probability of a vertical illuminance (lx), without direct sun in the eye: J. Wienold,
/// "Dynamic daylight glare evaluation", Building Simulation 2009.
double simplified_glare(double vertical_illuminance);

/// Glare of a view over the occupied hours.
struct GlareMetrics {
  /// DGP that 5% of the hours exceed: EN 17037:2018, annex E, asks for at most 0.45, 0.40 or 0.35.
  double exceeded = 0;
  std::array<std::size_t, 3> hours_above{};  ///< above kGlareClasses
};
/// Perceptible, disturbing and intolerable glare (Wienold, 2009; EN 17037:2018).
inline constexpr std::array<double, 3> kGlareClasses{0.35, 0.40, 0.45};

/// @param dgp, occupied one entry an hour of the year
GlareMetrics glare_metrics(std::span<const float> dgp, std::span<const std::uint8_t> occupied);

/// @param occupied one entry an hour of the year
std::vector<SensorMetrics> metrics_of(const Year& year, std::span<const std::uint8_t> occupied,
                                      const MetricLimits& limits = {});

/// @param chosen sensors of the zone @param weight Sensors::weight
ZoneMetrics metrics_of_zone(std::span<const SensorMetrics> metrics, std::span<const std::uint32_t> chosen,
                            std::span<const float> weight, const MetricLimits& limits = {});

/// The occupied hours of every day. @param text "FROM-TO" in hours of standard time, such as 8-18. Throws Error for
/// others.
std::vector<std::uint8_t> occupied_hours(const std::string& text, std::span<const WeatherHour> hours);

/// A number an hour from a text file: the last of each line, which commas or blanks divide. Lines that begin with #,
/// and a line of words at the start, are skipped. Throws Error, with the line, where it is no whole number from 0 to
/// `most`, and where there are not as many lines as hours.
std::vector<std::uint32_t> parse_schedule(std::string_view text, const std::string& path, std::size_t hours,
                                          std::uint32_t most);

}  // namespace glowworm
