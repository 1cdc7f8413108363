// The step that every path takes, from a ray to its hit and on: weaken by the medium, find light, resolve the material,
// choose a wavelength and a lobe, play roulette, leave. Cameras, gather rays, photons and the path tracer are policies
// over it: they say what becomes of light that is found, and of a surface that scatters.
#pragma once

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
/// @param finds_light whether the path takes the light that it meets
/// @param add_light takes that light: (RGB radiance, W sr^-1 m^-2; std::uint32_t source as in Scene::light_power(); a
///   function that gives the density per steradian by which light samples at a position choose it)
/// @param number gives a random number in [0, 1), for a wavelength
/// @param scatter of (Vertex&): returns whether the path goes on
/// @return whether the path goes on
template <typename AddLight, typename Number, typename Scatter>
bool meet(const Scene& scene, PathState& path, const Hit& hit, bool finds_light, const AddLight& add_light,
          const Number& number, const Scatter& scatter) {
  const Vec3 direction = path.ray.direction;
  if (hit.triangle == kNone) {
    if (finds_light)
      add_light(environment_radiance(scene, direction), environment_source(scene, direction),
                [&](Vec3 from) { return environment_pdf(scene, from, direction); });
    return false;
  }
  Vertex vertex = vertex_at(scene, path.ray, hit);
  if (!scene.media().empty()) vertex.media = media_at(scene, path.medium, hit.triangle, vertex.wo);
  if (finds_light && scene.geometry().emission_of(hit.triangle) != kNone) {
    const RGB emitted = emitted_radiance(scene, vertex.point, vertex.wo);
    if (!is_black(emitted))
      add_light(emitted, scene.emissive_index(hit.triangle),
                [&](Vec3 from) { return light_pdf(scene, from, vertex.point); });
  }
  resolve_material(scene, vertex, path.throughput, number);
  return scatter(vertex);
}

}  // namespace glowworm
