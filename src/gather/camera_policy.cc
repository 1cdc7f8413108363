#include "gather/camera_policy.h"

#include "transport/step.h"

namespace glowworm {

namespace {

/// Up to this many bounces, surface samples follow both reflection and refraction by clear glass. With a random choice,
/// a lamp that is rarely chosen would make single bright pixels.
constexpr int kSplitBounces = 4;

bool survives(CameraPath& path, float weight, float least, int bounce) {
  return survive(path, weight, least, bounce + 1, [&] { return path.sampler.next1(); }) > 0;
}

}  // namespace

CameraPolicy::CameraPolicy(const Tracer& tracer, const CameraPassSettings& settings, SlotRadiance& radiance,
                           FirstHit& first_hit, LightAdder& lights, GatherPoints& points,
                           std::vector<CameraPath>& branches)
    : scene_(tracer.scene()),
      settings_(settings),
      radiance_(radiance),
      first_hit_(first_hit),
      lights_(lights),
      points_(points),
      branches_(branches),
      in_media_(!scene_.media().empty()) {}

bool CameraPolicy::ends_on_diffuse(std::uint32_t slot, const Hit& hit) {
  DiffusePoint point;
  if (!sequence.of_surface() || takes_suns() || !diffuse_vertex(scene_, hit, point)) return false;
  first_hit_.surface_albedo[slot] += point.reflectance * sequence.share();
  return true;
}

bool CameraPolicy::advance(CameraPath& path, const Hit& hit, int bounce) {
  return meet(
      scene_, path, hit, true,
      [&](RGB light, std::uint32_t source, const auto& density) {
        add_emitted(path.slot, path.throughput * light * weight_of_met_light(path, density), source);
      },
      [&] { return path.sampler.next1(); }, [&](const Vertex& vertex) { return scatter(path, vertex, bounce); });
}

void CameraPolicy::add_emitted(std::uint32_t slot, RGB light, std::uint32_t source) {
  if (sequence.of_surface())
    radiance_.surface_emitted[slot] += light * sequence.share();
  else
    radiance_.add(radiance_.emitted, slot, light, source);
}

bool CameraPolicy::scatter(CameraPath& path, const Vertex& vertex, int bounce) {
  if (bounce == 0 && sequence.of_surface())
    first_hit_.surface_albedo[path.slot] += vertex.surface().albedo(vertex.wo, kAllLobes) * sequence.share();
  else if (bounce == 0)
    first_hit_.see(path.slot, vertex);
  // Surface samples see light through the specular lobes, and that of directional lights.
  if (takes_suns()) find_sun(path, vertex);
  if (sequence.of_surface()) return vertex.has(kSpecular) && follow_surface_sample(path, vertex, bounce);
  const float broad = broad_probability(vertex);
  if (broad >= 1 || path.sampler.next1() < broad) {
    add_gather_point(points_, vertex, path.throughput / broad, path.slot, path.sequence, path.sample, in_media_);
    return false;
  }
  path.throughput *= 1 / (1 - broad);
  return follow(path, vertex, bounce);
}

/// Takes one of the directional lights as the sun of a vertex, with all lobes that are not smooth.
void CameraPolicy::find_sun(CameraPath& path, const Vertex& vertex) {
  if (!takes_light_samples(vertex.bsdf)) return;
  const LightSample sample = sample_directional(scene_, vertex.point.position, path.sampler.next1());
  UnoccludedLight light = reflected_light(sample, vertex, kAllLobes, kAllLobes);
  light.radiance *= path.throughput * sequence.share();
  lights_.wait(path.slot, light);
}

/// Continues through the specular lobes of the surface. Without surface samples, rough ones reflect a light sample.
bool CameraPolicy::follow(CameraPath& path, const Vertex& vertex, int bounce) {
  Sampler& sampler = path.sampler;
  const float u_lobe = sampler.next1();
  const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, sampler.next2(), kSpecular);
  add_specular_light(path, vertex, path.throughput);
  return leave(path, vertex, s, s.weight) && survives(path, max_component(path.throughput), kLeastOfChains, bounce);
}

/// Adds a light sample that the rough specular lobes of a vertex reflect, for surface samples if there are some, and
/// notes whether all lobes are smooth.
/// @param factor on its light
void CameraPolicy::add_specular_light(CameraPath& path, const Vertex& vertex, RGB factor) {
  const Vec2 pair = path.sampler.next2();
  const float u = path.sampler.next1();
  const bool was_smooth = path.smooth;
  if (settings_.glints_apart) path.smooth &= smooth_lobes(vertex).count > 0;
  if (sequence.of_surface() != settings_.surface_samples || !takes_light_samples(vertex.bsdf)) return;
  const LightSample sample = sample_light(scene_, vertex, pair, u);
  const bool is_apart =
      (settings_.glints_apart && was_smooth && sample.delta) || (settings_.suns && sample.is_directional());
  if (!is_apart)
    lights_.add(radiance_.direct, path.slot, factor, reflected_light(sample, vertex, kSpecular, kSpecular));
}

/// Continues through the specular lobes, for lamps that are seen through them and light that rough ones reflect.
bool CameraPolicy::follow_surface_sample(CameraPath& path, const Vertex& vertex, int bounce) {
  const float u_lobe = path.sampler.next1();
  const Vec2 u = path.sampler.next2();
  add_specular_light(path, vertex, path.throughput * sequence.share());
  if (bounce < kSplitBounces) {
    const SmoothLobes lobes = smooth_lobes(vertex);
    if (lobes.count == 2) {
      const auto& [first, last] = lobes.ray;
      branches_.push_back(path);
      if (!leave(branches_.back(), vertex, last, last.weight * last.pdf)) branches_.pop_back();
      return leave(path, vertex, first, first.weight * first.pdf);
    }
  }
  const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, u, kSpecular);
  // Not by throughput: splitting makes it small, and would end paths. The first bounces are not left to chance.
  return leave(path, vertex, s, s.weight) &&
         (bounce < kSplitBounces || survives(path, max_component(s.weight), 1, bounce));
}

}  // namespace glowworm
