// Skies as formulas: the general skies of the CIE, the CIE overcast sky, and the all-weather sky of Perez.
#pragma once
#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm {

struct Environment;

/// A sky over a ground of one radiance. Above the horizon the radiance is
/// zenith (1 + a exp(b / y) + linear y) (1 + c (exp(d chi) - offset) + e cos(chi)^2), chi the angle to the sun.
/// Space has y up; north is -z and east is x.
struct SkyModel {
  float a = 0, b = -1, c = 0, d = -1, e = 0;
  float offset = 0;   ///< exp(d pi / 2) for the skies of the CIE, 0 for Perez's
  float linear = 0;   ///< 2 for the CIE overcast sky, else 0
  float zenith = 1;   ///< factor that gives W sr^-1 m^-2
  float ground = 0;   ///< radiance below the horizon, W sr^-1 m^-2
  Vec3 sun{0, 1, 0};  ///< unit, towards the sun
  bool operator==(const SkyModel&) const = default;
};

/// Radiance from a unit direction, W sr^-1 m^-2. Exact at the horizon: y > 0 is sky.
float sky_radiance(const SkyModel& sky, Vec3 direction);

/// Irradiance of the sky on a horizontal plane that faces up, W m^-2, by quadrature to a relative error below 1e-5.
double horizontal_irradiance(const SkyModel& sky);

/// Unit direction towards a place of the sky. @param altitude degrees above the horizon
/// @param azimuth degrees from north towards east
Vec3 sky_direction(float altitude, float azimuth);

/// The CIE standard general sky (CIE S 011/E:2003) of type 1 to 15, or for type 16 the CIE traditional overcast sky.
/// Its own disc of the sun is not in it. Throws Error for another type.
/// @param irradiance on the horizontal plane, W m^-2
/// @param ground_reflectance of the ground, which reflects that irradiance diffusely
SkyModel cie_sky(int type, Vec3 sun, double irradiance, double ground_reflectance);

/// An environment that shows a sky: radiance by the formula, directions sampled by a table.
Environment sky_environment(const SkyModel& sky);

}  // namespace glowworm
