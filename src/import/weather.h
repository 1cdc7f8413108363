// EnergyPlus weather files (EPW).
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "import/daylight.h"

namespace glowworm {

/// An hour of a weather file: the middle of its time with the sun up as the moment, and its irradiance, summed over the
/// hour's records.
struct WeatherHour {
  SkyMoment moment;
  SolarIrradiance irradiance;
  int hour = 12;  ///< 1 to 24: it ends then, standard time
};

/// Reads one hour. Throws Error with the line for a file that is not one, or cut off, and where the hour or some of its
/// records are missing.
/// @param hour 1 to 24, as the file counts them
WeatherHour parse_weather_hour(std::string_view text, const std::string& path, int month, int day, int hour);

/// All hours of a weather file, in its order.
struct WeatherYear {
  std::vector<WeatherHour> hours;
  /// What is strange, a sentence each: global horizontal irradiance that differs from direct and diffuse together,
  /// light at night, and a number of hours other than 8760 or 8784.
  std::vector<std::string> notes;
};

/// Reads all hours. Throws Error as parse_weather_hour() does, and for the first hour whose irradiance is missing.
/// @param turn SkyMoment::turn of all of them
WeatherYear parse_weather_year(std::string_view text, const std::string& path, double turn = 0);

}  // namespace glowworm
