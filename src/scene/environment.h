// Directions in and out of the image of an environment.
#pragma once
#include "core/distribution.h"
#include "scene/light.h"

namespace glowworm {

/// Radiance (W sr^-1 m^-2) from a unit direction in world space, towards the environment: by the formula of the sky, or
/// interpolated bilinearly.
RGB radiance(const Environment& environment, Vec3 direction);

/// The direction (world space, unit) of a point of the image; u to the right, v downwards, both in [0, 1].
/// Equal area: P. Clarberg, "Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD", JGT 13(3), 2008.
Vec3 environment_direction(const Environment& environment, Vec2 uv);

/// The point of the image for a unit direction in world space: the inverse of environment_direction().
Vec2 environment_coordinates(const Environment& environment, Vec3 direction);

/// Steradians per unit of area of the image (u, v in [0, 1]) at uv.
float environment_solid_angle(const Environment& environment, Vec2 uv);

/// Radiance from a direction, and the density per steradian with which `distribution`, made by
/// environment_distribution(), samples it.
struct EnvironmentValue {
  RGB radiance;
  float pdf;
};
EnvironmentValue radiance_and_pdf(const Environment& environment, const Distribution2D& distribution, Vec3 direction);

/// Samples a direction by `distribution`. The density per steradian is continuous: it interpolates that of the texels,
/// like the radiance.
Vec3 sample_environment_direction(const Environment& environment, const Distribution2D& distribution, Vec2 u);

/// The same direction, with the result of radiance_and_pdf(), up to rounding.
struct EnvironmentDirection {
  Vec3 direction;  ///< unit, world space, towards the environment
  EnvironmentValue value;
};
EnvironmentDirection sample_environment(const Environment& environment, const Distribution2D& distribution, Vec2 u);

/// Luminance times solid angle of each texel as a distribution over the image; empty if there is no image.
Distribution2D environment_distribution(const Environment& environment);

/// One environment with the radiance of both, in the image of the one with more pixels. Their axes must be orthonormal,
/// and neither may be a formula.
Environment sum_of(const Environment& a, const Environment& b);

/// Integral of the radiance over all directions, W m^-2; for a sky, that of its table.
RGB environment_integral(const Environment& environment);

}  // namespace glowworm
