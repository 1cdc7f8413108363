// A clear sky for the built-in scenes.
#pragma once
#include "core/rgb.h"
#include "core/vec.h"
#include "scene/light.h"

namespace glowworm {

/// The radiance of a clear sky by Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999
/// (section 3.1 and appendix A.2: Perez' formula in luminance and chromaticity), without the sun's disc. One unit of
/// radiance stands for a luminance of 10 kcd/m^2, so that one unit of irradiance stands for 10 klx.
/// @param to_sun unit, towards the sun, above the horizon (y > 0); @param direction unit; below the horizon the
///               horizon's radiance is given
RGB clear_sky_radiance(Vec3 direction, Vec3 to_sun, float turbidity);

/// That sky as an environment with a lat-long image of height x 2 height pixels, and below the horizon a ground that
/// reflects a fifth of the sky's irradiance.
Environment clear_sky(Vec3 to_sun, float turbidity, int height);

/// The sun of such a sky: its irradiance is that of 9 units (90 klx) across the light, a usual clear day's.
Light clear_sun(Vec3 to_sun);

}  // namespace glowworm
