// Light samples of a vertex (next-event estimation), weighted against directions that meet the same light.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bsdf/phase.h"
#include "scene/light_sampling.h"
#include "transport/step.h"

namespace glowworm {

/// Relative error of a shadow ray's length and direction: 16 half units in the last place.
inline constexpr float kShadowError = 0x1p-20f;

/// Weight of a sample from a strategy that takes `count` samples of density `pdf`, beside a second strategy: the
/// balance heuristic (Veach 1997, equation 9.8).
inline float balance_heuristic(float count, float pdf, float other_count, float other_pdf) {
  const float own = count * pdf, other = other_count * other_pdf;
  return own + other > 0 ? own / (own + other) : 0;
}

/// Weight of light that a path meets, against one light sample where it last scattered.
/// @param density as meet() gives it
template <typename Density>
float weight_of_met_light(const PathState& path, Density&& density) {
  return path.pdf > 0 ? balance_heuristic(1, path.pdf, 1, density(path.scattered_at)) : 1;
}

/// Light of one light sample that a vertex scatters, before the test of what is in its way (passed_share()).
struct UnoccludedLight {
  RGB radiance{0.0f};  ///< f_r cos L / pdf, W sr^-1 m^-2; black if no test is needed
  Ray shadow_ray;
  std::uint32_t source = kNone;  ///< light source, counted as in Scene::light_power()
  PathMedium medium{};           ///< at the start of the shadow ray
  std::optional<Vec2> random;    ///< as LightSample::random
};

/// Share of the light that arrives: none if something is in the way, less through panes and media.
RGB passed_share(const Tracer& tracer, const UnoccludedLight& light);
/// The same of many.
std::vector<RGB> passed_shares(const Tracer& tracer, std::span<const UnoccludedLight> lights);

/// Adds light samples to slots of radiance, as far as they arrive there.
class LightAdder {
 public:
  LightAdder(const Tracer& tracer, SlotRadiance& radiance) : tracer_(tracer), radiance_(radiance) {}

  /// Traces the shadow ray. @param part of the radiance @param factor on the light
  void add(std::vector<RGB>& part, std::uint32_t slot, RGB factor, const UnoccludedLight& light);
  /// Leaves the light to add_waiting(), which is faster for many.
  void wait(std::uint32_t slot, const UnoccludedLight& light);
  /// Adds what waits to a part.
  void add_waiting(std::vector<RGB>& part);

  std::uint64_t shadow_rays = 0;

 private:
  const Tracer& tracer_;
  SlotRadiance& radiance_;
  std::vector<UnoccludedLight> waiting_;
  std::vector<std::uint32_t> slots_;  // of these
};

/// A light sample for a vertex, by three random numbers in [0, 1).
inline LightSample sample_light(const Scene& scene, const Vertex& vertex, Vec2 pair, float u) {
  return sample_light(scene, vertex.point.position, pair.x, {u, pair.y});
}

/// Reflected light of a light sample, where `scattered` is f_r cos of the lobes in question.
/// @param weight against other ways to find the same light
UnoccludedLight reflected_light(const LightSample& light, const Vertex& vertex, RGB scattered, float weight);

/// What the given lobes of a vertex reflect of a light sample for it: f_r cos L / pdf, and weighted against samples of
/// directions.
/// @param lights, directions numbers of samples that bring the same light
/// @param density            gives the density of a sample of a direction, per steradian
template <typename Density>
UnoccludedLight reflected_light(const LightSample& light, const Vertex& vertex, Lobes lobes, float lights,
                                float directions, Density&& density) {
  if (!(light.pdf > 0) || is_black(light.radiance)) return {};
  const RGB scattered = vertex.surface().evaluate(vertex.wo, light.direction, lobes);
  if (is_black(scattered)) return {};
  const float weight = light.delta ? 1 : balance_heuristic(lights, light.pdf, directions, density(light.direction));
  return reflected_light(light, vertex, scattered, weight);
}
/// The same beside one direction, sampled from the lobes `sampled`.
inline UnoccludedLight reflected_light(const LightSample& light, const Vertex& vertex, Lobes lobes, Lobes sampled) {
  return reflected_light(light, vertex, lobes, 1, 1,
                         [&](Vec3 w) { return vertex.surface().pdf(vertex.wo, w, sampled); });
}

/// A place in a medium where a path scatters.
struct MediumVertex {
  Vec3 position, wo;  ///< metres; unit, back along the path
  float g = 0;        ///< of the medium
  PathMedium medium;
  float time = 0;  ///< of the path, as Ray::time

  /// Share of light from wi that it scatters, per steradian.
  float phase(Vec3 wi) const { return henyey_greenstein(-dot(wo, wi), g); }
  /// A direction with that density.
  Vec3 sample(Vec2 u) const { return sample_henyey_greenstein(wo, g, u); }
};
/// Scattered light of a light sample, for a coefficient of 1.
/// @param weight against other ways to find the same light
UnoccludedLight scattered_light(const LightSample& light, const MediumVertex& vertex, float weight);

/// Whether light samples may reach some of the viewer. None do from a perfectly smooth surface, so that choosing a
/// light for it is wasted. Mixtures of smooth lobes with others count as reached.
bool takes_light_samples(const Bsdf& bsdf);

}  // namespace glowworm
