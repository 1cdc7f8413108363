// The step that every path takes, from a ray to its hit and on: weaken by the medium, find light, resolve the material,
// choose a wavelength and a lobe, play roulette, leave. Cameras, gather rays, photons and the path tracer are policies
// over it: they say what becomes of light that is found, and of a surface that scatters.
#pragma once
#include <cstdint>

#include "scene/light_sampling.h"
#include "transport/medium.h"
#include "transport/roulette.h"
#include "transport/vertex.h"

namespace glowworm {

/// A ray that leaves a surface. @param side the geometric normal on the side where the ray leaves
/// @param offset distance along `side` at which the ray starts (offset_origin()), metres
Ray leave_surface(Vec3 position, Vec3 side, float offset, Vec3 direction, float time);

/// Sends a path on from a vertex in a sampled direction. Returns false if it carries nothing there.
/// @param weight factor on the throughput
bool leave(PathState& path, const Vertex& vertex, const ScatteredRay& sampled, RGB weight);

/// Russian roulette (transport/roulette.h). Returns the probability by which the path survives, for the caller to
/// divide by, or 0 if it ends.
/// @param number gives a random number in [0, 1); called only where the path may end
template <typename Number>
float roulette(float weight, float least, int bounces, Number&& number) {
  const float probability = survival(weight, least, bounces);
  if (probability >= 1) return 1;
  return probability > 0 && number() < probability ? probability : 0;
}

/// Plays roulette() for a path, and divides the throughput of one that survives by the probability. Returns that, or 0.
template <typename Number>
float survive(PathState& path, float weight, float least, int bounces, Number&& number) {
  const float probability = roulette(weight, least, bounces, number);
  if (probability > 0) path.throughput *= 1 / probability;
  return probability;
}

/// Takes a path to the surface that it has met, or out of the scene.
///
/// The policy has
///   bool finds_light(): whether it wants the light that the path meets
///   void add_light(RGB radiance, std::uint32_t source, density): that light, W sr^-1 m^-2, its source as in
///     Scene::light_power(), and a function that gives the density per steradian by which light samples at a position
///     choose it
///   float wavelength_number(): a random number in [0, 1)
///   bool scatter(Vertex&): whether the path goes on
/// @return whether the path goes on
template <typename Policy>
bool meet(const Scene& scene, PathState& path, const Hit& hit, Policy&& policy) {
  const Vec3 direction = path.ray.direction;
  if (hit.triangle == kNone) {
    if (policy.finds_light())
      policy.add_light(environment_radiance(scene, direction), environment_source(scene, direction),
                       [&](Vec3 from) { return environment_pdf(scene, from, direction); });
    return false;
  }
  Vertex vertex = vertex_at(scene, path.ray, hit);
  if (!scene.media().empty()) vertex.media = media_at(scene, path.medium, hit.triangle, vertex.wo);
  if (scene.geometry().emission_of(hit.triangle) != kNone && policy.finds_light()) {
    const RGB emitted = emitted_radiance(scene, vertex.point, vertex.wo);
    if (!is_black(emitted))
      policy.add_light(emitted, scene.emissive_index(hit.triangle),
                       [&](Vec3 from) { return light_pdf(scene, from, vertex.point); });
  }
  resolve_material(scene, vertex, path.throughput, [&] { return policy.wavelength_number(); });
  return policy.scatter(vertex);
}

}  // namespace glowworm
