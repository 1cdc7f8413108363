// Sampling light: towards a point (next-event estimation) and away from the lights (photons).
#pragma once
#include <cmath>
#include <optional>

#include "core/rgb.h"
#include "core/vec.h"
#include "scene/scene.h"
#include "scene/surface.h"

namespace glowworm {

/// A direction towards light, from a point.
struct LightSample {
  Vec3 direction;      ///< unit, from the point to the light
  float distance = 0;  ///< metres; infinity for the environment and directional lights
  RGB radiance;        ///< unoccluded radiance along it; for deltas, irradiance across it
  float pdf = 0;       ///< per steradian, including the choice of the light; for deltas, the probability of the choice
  bool delta = false;
  Vec3 position;                 ///< of the point on the light if `distance` is finite, metres
  Vec3 normal;                   ///< of the light there, unit, towards the point; (0,0,0) for a delta
  float offset = 0;              ///< distance from the light at which rays end or start (offset_origin()), metres
  std::uint32_t source = kNone;  ///< counted as in Scene::light_power()
  /// The random numbers that chose the point. Estimates of the transmittance of media start from them, because all
  /// samples of a light without size have the same ray. None: transmittances are integrated.
  std::optional<Vec2> random;

  bool is_directional() const { return delta && std::isinf(distance); }
};

/// Mean radiance of an emissive triangle at a point, over the rays that meet it and those for which it is absent.
RGB mean_emission(const Scene& scene, std::uint32_t triangle, Vec2 barycentric);

/// Chooses a light for a position (metres), and a direction to it. pdf = 0 if the light cannot light the position.
/// @param u_light chooses the light. Its remainder replaces u.x, unless the light's probability is tiny, so that (u.x,
/// u.y) is stratified over all lights together
/// @param u       the point on the light; all in [0, 1)
LightSample sample_light(const Scene& scene, Vec3 position, float u_light, Vec2 u);
/// The same for one of many samples of a position.
LightSample sample_light(const Scene& scene, Vec3 position, LightSelector::AtPoint& lights, float u_light, Vec2 u);

/// The same for one source, counted as in Scene::light_power(): its pdf leaves out the choice. The point of a lamp
/// depends on `u` alone.
LightSample sample_light_of(const Scene& scene, std::uint32_t source, Vec3 position, Vec2 u);

/// The sample of a light without size. Its pdf leaves out the choice; it is 0 if the light cannot light the position.
/// @param position metres
LightSample sample_delta(const Light& light, Vec3 position);

/// A sample of one of the directional lights, which exist, chosen by power. @param u in [0, 1)
LightSample sample_directional(const Scene& scene, Vec3 position, float u);

/// The density per steradian with which sample_light() at `position` samples the direction to `on_light`, a point of an
/// emissive triangle.
float light_pdf(const Scene& scene, Vec3 position, const SurfacePoint& on_light);
/// The same for a direction towards the environment.
float environment_pdf(const Scene& scene, Vec3 position, Vec3 direction);

/// The light source of the environment in a direction (unit, world space, towards it), counted as in
/// Scene::light_power(); the parts of an environment follow each other.
std::uint32_t environment_source(const Scene& scene, Vec3 direction);
/// Radiance of the environment from a direction (unit, world space, towards it); black without one.
RGB environment_radiance(const Scene& scene, Vec3 direction);

/// A photon at its start from a light.
struct EmittedPhoton {
  Vec3 origin;
  Vec3 direction;               ///< unit
  RGB flux;                     ///< W for a single photon: divide by the number emitted
  std::uint32_t light = kNone;  ///< source, counted as in Scene::light_power()
};

/// Emits a photon: chooses the source in proportion to power, then position and direction by the source's emission.
/// A photon of a medium may start where surfaces leave that out; it has no flux then, which only rays can tell.
EmittedPhoton sample_emission(const Scene& scene, float u_light, Vec2 u_position, Vec2 u_direction);

/// A name for messages and statistics.
std::string light_source_name(const Scene& scene, std::uint32_t source);

}  // namespace glowworm
