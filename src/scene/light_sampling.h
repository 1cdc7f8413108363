// Sampling light: towards a point (next-event estimation) and away from the lights (photons).
#pragma once
#include "core/rgb.h"
#include "core/vec.h"
#include "scene/scene.h"
#include "scene/surface.h"

namespace glowworm {

/// A direction towards light, from a point.
struct LightSample {
  Vec3 direction;      ///< unit, from the point to the light
  float distance = 0;  ///< metres; infinity for the environment and directional lights
  RGB radiance;        ///< what arrives along it if nothing is between: radiance; for deltas, irradiance across it
  float pdf = 0;       ///< per steradian, with the choice of the light in it; for deltas, the probability of the choice
  bool delta = false;
  Vec3 position;     ///< of the place on the light where `distance` is finite, metres
  Vec3 normal;       ///< of the light there, unit, towards the point; (0,0,0) for a delta
  float offset = 0;  ///< how far before the light rays must end or begin (offset_origin()), metres
};

/// Chooses a light for the point (position, and normal on the side that is lit; a zero normal: any side), and a
/// direction to it. pdf = 0 where the light cannot light the point.
/// @param u_light chooses the light and, stretched over the light's share, stands for u.x unless that share is tiny:
///                with u.y a pair that is stratified over all lights at once
/// @param u       the place on the light; all in [0, 1)
LightSample sample_light(const Scene& scene, Vec3 position, Vec3 normal, float u_light, Vec2 u);

/// The density per steradian with which sample_light() at `position` gives the direction to `on_light`, a point of an
/// emissive triangle.
float light_pdf(const Scene& scene, Vec3 position, Vec3 normal, const SurfacePoint& on_light);
/// The same for a direction in which the environment is seen.
float environment_pdf(const Scene& scene, Vec3 position, Vec3 normal, Vec3 direction);

/// Radiance of the environment from a direction (unit, world space, towards it); black where there is none.
RGB environment_radiance(const Scene& scene, Vec3 direction);

/// A photon as it leaves a light.
struct EmittedPhoton {
  Vec3 origin;
  Vec3 direction;               ///< unit
  RGB flux;                     ///< W if it were the only photon: divide by the number emitted
  std::uint32_t light = kNone;  ///< source, counted as in Scene::light_power()
};

/// Emits a photon: the source in proportion to power, then place and direction by the source's own emission.
EmittedPhoton sample_emission(const Scene& scene, float u_light, Vec2 u_position, Vec2 u_direction);

/// The power of a light source in W (RGB), counted as in Scene::light_power().
RGB light_source_power(const Scene& scene, std::uint32_t source);
/// A name for messages and statistics.
std::string light_source_name(const Scene& scene, std::uint32_t source);

}  // namespace glowworm
