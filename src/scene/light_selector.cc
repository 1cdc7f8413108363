#include "scene/light_selector.h"

#include <algorithm>
#include <cmath>

#include "core/rgb.h"

namespace glowworm {

namespace {

/// Near and far lights each get at least this share if both exist, because the estimates of their irradiance ignore
/// shadows.
constexpr float kMinShare = 0.1f;

LightBounds bounds_of(const Geometry& g, std::uint32_t triangle, const Emission& emission, float power) {
  LightBounds b;
  for (const std::uint32_t corner : g.triangles[triangle]) b.box.grow(g.positions[corner]);
  b.axis = g.normal(triangle);
  b.two_sided = emission.two_sided;
  // Power is pi times the intensity along the normal, of either side.
  b.intensity = power * kInversePi / (emission.two_sided ? 2.0f : 1.0f);
  if (emission.profile) {
    // As bright in every direction of its front as it is anywhere, without Lambert's cosine.
    b.intensity = power * emission.profile->peak();
    b.cos_emission = std::nextafter(0.0f, -1.0f);
  }
  return b;
}

LightBounds bounds_of(const Light& light) {
  LightBounds b;
  b.box.grow(light.position);
  b.intensity = luminance(light.intensity);
  if (light.kind == LightKind::spot) {
    b.axis = light.direction;
    b.cos_normals = light.cos_inner;
    b.cos_emission = std::cos(std::acos(light.cos_outer) - std::acos(light.cos_inner));
  } else {
    if (light.kind == LightKind::luminaire)
      b.intensity *= light.table->greatest() * light.table->tilt_factor(light.direction);
    b.cos_normals = -1;
  }
  return b;
}

}  // namespace

LightSelector::LightSelector(const Geometry& geometry, std::span<const std::uint32_t> emissive_triangles,
                             std::span<const Emission> emissions, std::span<const Light> lights, std::size_t media,
                             std::span<const float> powers, float disc) {
  std::vector<LightBounds> near;
  std::vector<float> far, directional;
  const std::size_t triangles = emissive_triangles.size();
  for (std::uint32_t source = 0; source < powers.size(); ++source) {
    const bool is_triangle = source < triangles, is_light = !is_triangle && source < triangles + lights.size();
    if (source >= triangles + lights.size() && source < triangles + lights.size() + media) {
      place_.push_back(kNone);
      continue;
    }
    if (is_triangle || (is_light && lights[source - triangles].kind != LightKind::directional)) {
      place_.push_back(static_cast<std::uint32_t>(near.size()));
      near_source_.push_back(source);
      const std::uint32_t t = is_triangle ? emissive_triangles[source] : 0;
      near.push_back(is_triangle ? bounds_of(geometry, t, emissions[geometry.emission[t]], powers[source])
                                 : bounds_of(lights[source - triangles]));
      if (!(powers[source] > 0)) near.back().intensity = 0;
    } else {
      place_.push_back(static_cast<std::uint32_t>(far.size()) | kFar);
      far_source_.push_back(source);
      far.push_back(powers[source]);
      if (!is_light || !(powers[source] > 0)) continue;
      directional_source_.push_back(source);
      directional.push_back(powers[source]);
    }
  }
  tree_ = LightTree(near);
  if (far.empty()) return;
  far_ = Distribution1D(far);
  if (!directional.empty()) directional_ = Distribution1D(directional);
  if (disc > 0) far_irradiance_ = static_cast<float>(far_.total() / disc);
}

float LightSelector::far_share(Vec3 position) const {
  if (!(far_irradiance_ > 0)) return 0;
  const float near = tree_.irradiance(position);
  if (!(near > 0)) return 1;
  return std::clamp(far_irradiance_ / (far_irradiance_ + near), kMinShare, 1 - kMinShare);
}

LightSelector::Choice LightSelector::choose_directional(float u) const {
  const Distribution1D::Sample sample = directional_.sample(u);
  return {directional_source_[sample.index], sample.probability, sample.remapped};
}

LightSelector::Choice LightSelector::AtPoint::choose(float u) {
  const float share = far_share_;
  if (u < share) {
    const Distribution1D::Sample sample = selector_.far_.sample(std::min(u / share, kBelowOne));
    return {selector_.far_source_[sample.index], share * sample.probability, sample.remapped};
  }
  if (selector_.tree_.empty()) return {};
  const LightTree::Choice choice =
      selector_.tree_.choose(position_, std::min((u - share) / (1 - share), kBelowOne), descent_);
  return {selector_.near_source_[choice.light], (1 - share) * choice.probability, choice.remapped};
}

float LightSelector::probability(Vec3 position, std::uint32_t source) const {
  const std::uint32_t place = place_[source];
  if (place == kNone) return 0;
  const float share = far_share(position);
  if (place & kFar) return share > 0 ? share * far_.probability(place & ~kFar) : 0.0f;
  return share < 1 ? (1 - share) * tree_.probability(position, place) : 0.0f;
}

}  // namespace glowworm
