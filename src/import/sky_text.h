// Skies as the command line names them.
#pragma once
#include <string>

#include "scene/scene.h"

namespace glowworm {

/// Checks a text of --sky. Throws Error, with the forms, for others.
void check_sky(const std::string& text);

/// Replaces the environment by the sky of a text of --sky:
/// "cie:TYPE[,ALTITUDE,AZIMUTH[,LUX[,GROUND]]]": the CIE standard general sky of type 1 to 15, or 16, the traditional
/// overcast sky. ALTITUDE and AZIMUTH of the sun are degrees (45 and 180, south; from north, -z, towards east, x), LUX
/// is the illuminance of the sky on the horizontal plane (10,000) by 179 lm/W, and GROUND the reflectance of the ground
/// below the horizon (0.2).
/// "perez:DIRECT,DIFFUSE,MONTH,DAY,HOUR,LATITUDE,LONGITUDE,ZONE[,GROUND]": sun and sky by direct normal and diffuse
/// horizontal irradiance (W m^-2), standard time and place (SkyMoment).
/// "epw:FILE,MONTH,DAY,HOUR[,GROUND]": the same by the hour (1 to 24) of a weather file.
/// Throws Error as check_sky(), add_perez_sky() and parse_weather_hour() do.
/// @param turn degrees from -z to north, counter-clockwise seen from above
void add_sky(const std::string& text, double turn, SceneDescription& scene);

}  // namespace glowworm
