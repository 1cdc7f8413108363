// Sun and sky of a place and time: solar geometry and the all-weather sky of Perez.
#pragma once
#include <optional>

#include "scene/scene.h"

namespace glowworm {

/// A moment of solar geometry.
struct SkyMoment {
  int month = 6, day = 21;
  double hour = 12;                    ///< standard time, 0 to 24
  double latitude = 0, longitude = 0;  ///< degrees, north and east positive
  double zone = 0;                     ///< hours of standard time before UTC's, east positive
  double turn = 0;                     ///< degrees from the scene's -z to north, counter-clockwise seen from above
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

/// Sun and sky of a moment.
struct PerezSky {
  SkyModel shape;                  ///< with a zenith factor of 1 and a black ground
  double diffuse = 0, direct = 0;  ///< of the sky, horizontal; of the sun, normal; visible light, W m^-2

  /// Irradiance of both on a horizontal plane.
  double horizontal() const { return diffuse + direct * shape.sun.y; }
};

/// Sun and sky by Perez, Seals and Michalsky, "All-weather model for sky luminance distribution", Solar Energy 50(3),
/// 1993. Light is visible light: luminous efficacy of sun and sky by Perez et al., Solar Energy 44(5), 1990, over 179
/// lm/W. In civil twilight the sky is as with the sun on the horizon, and the sun gives no light. Nothing where the sun
/// is lower, or all irradiance is 0.
std::optional<PerezSky> perez_sky(const SkyMoment& moment, const SolarIrradiance& measured);

/// Replaces the environment by perez_sky(), and adds the sun as a directional light. The sky's horizontal illuminance
/// is exactly the diffuse irradiance; without any, it is black. Throws Error where there is no sky.
/// @param ground reflectance of the ground, which reflects the light of sun and sky
void add_perez_sky(const SkyMoment& moment, const SolarIrradiance& measured, double ground, SceneDescription& scene);

}  // namespace glowworm
