// A clear sky for the built-in scenes.
#pragma once
#include "core/rgb.h"
#include "core/vec.h"
#include "scene/light.h"

namespace glowworm {

/// The radiance of a clear sky after Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight", SIGGRAPH
/// 1999 (section 3.1 and appendix A.2: Perez' formula in luminance and chromaticity), without the sun's disc. One unit
/// of radiance represents a luminance of 10 kcd/m^2; one unit of irradiance represents 10 klx.
/// @param to_sun unit, towards the sun, above the horizon (y > 0)
/// @param direction unit; directions below the horizon give the horizon's radiance
RGB clear_sky_radiance(Vec3 direction, Vec3 to_sun, float turbidity);

/// The same sky as an environment with a lat-long image of height x 2 height pixels. Below the horizon is a ground that
/// reflects a fifth of the sky's irradiance.
Environment clear_sky(Vec3 to_sun, float turbidity, int height);

/// The sun of such a sky. Its irradiance perpendicular to the light is 9 units (90 klx), as on a typical clear day.
Light clear_sun(Vec3 to_sun);

}  // namespace glowworm
