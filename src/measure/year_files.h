// Tables of a year of daylight.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "measure/annual_metrics.h"
#include "measure/view_year.h"
#include "measure/year.h"

namespace glowworm {

/// A box whose sensors are rated together.
struct RatedBox {
  std::string name;
  Vec3d min, max;  ///< metres, in the axes of the user's file

  bool contains(Vec3d p) const;
};

/// @param text "NAME,X0,Y0,Z0,X1,Y1,Z1". Throws Error for others.
RatedBox parse_rated_box(const std::string& text);

/// A rated year.
struct RatedYear {
  std::vector<Vec3d> place;   ///< of sensors, metres, in the axes of the user's file
  std::vector<Vec3> normal;   ///< unit, in these axes
  std::vector<bool> upright;  ///< whether the normal is horizontal, so that simplified glare has a meaning
  std::vector<SensorMetrics> metrics;
  std::vector<float> daylight_factor, relative_error;
  std::vector<std::string> zone_names;
  std::vector<ZoneMetrics> zones;
  MetricLimits limits;
};

/// A row an hour: month, day, hour (its end, standard time), and the illuminance of each sensor in lx.
std::string year_csv(const Year& year, std::span<const WeatherHour> hours, const std::string& about);

/// "view 1: DGP 0.382 is exceeded in 5% of the occupied hours; ..." for people, with the root mean squares of the
/// errors over the occupied hours with light.
/// @param number of the view, from 0 on @param occupied one entry an hour of the year
std::string glare_text(std::size_t number, const ViewYear& view, std::span<const std::uint8_t> occupied);

/// A row an hour, as year_csv() has them: DGP and vertical illuminance (lx) of each view, and the errors of both;
/// glare_text() as comments.
std::string glare_csv(std::span<const ViewYear> views, std::span<const WeatherHour> hours,
                      std::span<const std::uint8_t> occupied, const std::string& about);

/// A row a sensor; zones as comments.
std::string metrics_csv(const RatedYear& rated, const std::string& about);
/// One object: "about", "limits", "zones" and "sensors".
std::string metrics_json(const RatedYear& rated, const std::string& about);

/// "sDA 54.2%, ASE 3.1%, ..." of a zone, for people.
std::string zone_text(const std::string& name, const ZoneMetrics& zone, const MetricLimits& limits);

}  // namespace glowworm
