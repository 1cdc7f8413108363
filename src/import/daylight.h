// Sun and sky of a place and time: solar geometry, the all-weather sky of Perez, and weather files.
#pragma once
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace glowworm {

/// A moment of solar geometry.
struct SkyMoment {
  int month = 6, day = 21;
  double hour = 12;                    ///< standard time, 0 to 24
  double latitude = 0, longitude = 0;  ///< degrees, north and east positive
  double zone = 0;                     ///< hours of standard time before UTC's, east positive
};

/// The sun's place, degrees.
struct SunPlace {
  double altitude = 0, azimuth = 0;  ///< above the horizon; from north towards east
};
/// The sun's place by the formulas of the IES Lighting Handbook (as Radiance's gensky), right to some 0.3 degrees.
SunPlace sun_place(const SkyMoment& moment);

/// Irradiance of a weather station, W m^-2 of the whole solar spectrum.
struct SolarIrradiance {
  double direct_normal = 0, diffuse_horizontal = 0;
};

/// Replaces the environment by the sky of Perez, Seals and Michalsky, "All-weather model for sky luminance
/// distribution", Solar Energy 50(3), 1993, and adds the sun as a directional light. Light is visible light: luminous
/// efficacy of sun and sky by Perez et al., Solar Energy 44(5), 1990, over 179 lm/W. The sky's horizontal illuminance
/// is exactly that of the diffuse irradiance; without any, it is black. In civil twilight the sky is as with the sun on
/// the horizon, and the sun gives no light. Throws Error where the sun is lower, or all irradiance is 0.
/// @param ground reflectance of the ground, which reflects the light of sun and sky
void add_perez_sky(const SkyMoment& moment, const SolarIrradiance& measured, double ground, SceneDescription& scene);

/// The hour of an EnergyPlus weather file (EPW): the middle of its time with the sun up as the moment, and its
/// irradiance, summed over the hour's records. Throws Error with the line for a file that is not one, or cut off, and
/// where the hour or some of its records are missing.
/// @param hour 1 to 24, as the file counts them
struct WeatherHour {
  SkyMoment moment;
  SolarIrradiance irradiance;
};
WeatherHour parse_weather_hour(std::string_view text, const std::string& path, int month, int day, int hour);

}  // namespace glowworm
