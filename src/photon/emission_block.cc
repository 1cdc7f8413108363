#include "photon/emission_block.h"

#include "core/warp.h"
#include "scene/environment.h"

namespace glowworm {

namespace {

/// Arrays of a block for the kernels.
template <typename Pointers, typename Arrays>
void point_to(Pointers& pointers, Arrays& arrays) {
  for (std::size_t k = 0; k < std::size(arrays); ++k) pointers[k] = arrays[k];
}

}  // namespace

void EmissionBlock::set_numbers(std::size_t i, const EmissionNumbers& numbers, float guide_weight) {
  choice_[i] = numbers[0];
  place_[0][i] = numbers[1];
  place_[1][i] = numbers[2];
  square_[0][i] = numbers[3];
  square_[1][i] = numbers[4];
  guide_weight_[i] = guide_weight;
}

void EmissionBlock::emit(const Scene& scene, std::size_t count) {
  bool any[kKinds] = {};
  for (std::size_t i = 0; i < count; ++i) {
    kind_[i] = choose(scene, i);
    any[kind_[i]] = true;
  }
  EmissionChoices choices;
  choices.count = count;
  choices.probability = probability_;
  choices.guide_weight = guide_weight_;
  point_to(choices.place, place_);
  point_to(choices.square, square_);
  if (any[kDistant]) emit_distant(scene, choices);
  if (any[kTriangle]) {
    set_triangles(scene, count);
    emit_triangles(choices, any[kDistant]);
  }
  if (!any[kOther]) return;
  for (std::size_t i = 0; i < count; ++i)
    if (kind_[i] == kOther) emit_other(scene, i);
}

EmissionBlock::Kind EmissionBlock::choose(const Scene& scene, std::size_t i) {
  if (!(scene.light_power().total() > 0)) return kOther;
  const std::uint32_t source = scene.light_power().index(choice_[i]);
  light_[i] = source;
  probability_[i] = scene.light_power().probability(source);
  const std::size_t triangles = scene.emissive_triangles().size();
  if (source < triangles) {
    const std::uint32_t emission = scene.geometry().emission[scene.emissive_triangles()[source]];
    return scene.emissions()[emission].profile ? kOther : kTriangle;
  }
  if (source < triangles + scene.lights().size()) {
    const Light& light = scene.lights()[source - triangles];
    if (light.kind != LightKind::directional) return kOther;
    set_distant(i, light.direction, light.intensity);
    return kDistant;
  }
  if (source < scene.first_environment_source()) return kOther;
  const EnvironmentDirection sample =
      sample_environment(*scene.environment(), scene.environment_distribution(), {square_[0][i], square_[1][i]});
  light_[i] = environment_source(scene, sample.direction);
  const bool seen = sample.value.pdf != 0;
  set_distant(i, -sample.direction, seen ? sample.value.radiance / sample.value.pdf : RGB(0.0f));
  return kDistant;
}

void EmissionBlock::set_triangles(const Scene& scene, std::size_t count) {
  const Geometry& g = scene.geometry();
  const std::uint32_t* const emission_of = g.emission.data();
  const Emission* const emissions = scene.emissions().data();
  const std::uint32_t* const emissive = scene.emissive_triangles().data();
  for (std::size_t i = 0; i < count; ++i) {
    if (kind_[i] != kTriangle) continue;
    const std::uint32_t triangle = emissive[light_[i]];
    DiffuseTriangleRoom room;
    const DiffuseTriangle& placed = scene.diffuse_triangle(triangle, room);
    for (int k = 0; k < 3; ++k) {
      corner_[k][i] = placed.corner[k];
      edges_[k][i] = placed.edge[0][k];
      edges_[k + 3][i] = placed.edge[1][k];
      normal_[k][i] = placed.normal[k];
    }
    offset_[i] = placed.offset();
    const Emission& emission = emissions[emission_of[triangle]];
    const bool is_even = emission.radiance.texture == kNone && !scene.has_alpha(g.material[triangle]);
    const RGB radiance = is_even ? emission.radiance.value
                                 : mean_emission(scene, triangle, square_to_triangle({place_[0][i], place_[1][i]}));
    radiance_[0][i] = radiance.r;
    radiance_[1][i] = radiance.g;
    radiance_[2][i] = radiance.b;
    two_sided_[i] = emission.two_sided;
  }
}

void EmissionBlock::set_distant(std::size_t i, Vec3 direction, RGB irradiance) {
  for (int k = 0; k < 3; ++k) {
    distant_direction_[k][i] = direction[k];
    radiance_[k][i] = irradiance[k];
  }
}

void EmissionBlock::emit_distant(const Scene& scene, const EmissionChoices& choices) {
  DistantLight light;
  point_to(light.direction, distant_direction_);
  point_to(light.irradiance, radiance_);
  for (int axis = 0; axis < 3; ++axis) light.center[axis] = scene.center()[axis];
  light.radius = scene.radius();
  EmittedRays out;
  point_to(out.origin, origin_);
  point_to(out.direction, direction_);
  point_to(out.flux, flux_);
  emit_from_afar(choices, light, out);
}

void EmissionBlock::emit_triangles(const EmissionChoices& choices, bool others) {
  EmittingTriangles triangles;
  point_to(triangles.corner, corner_);
  point_to(triangles.edges, edges_);
  point_to(triangles.normal, normal_);
  triangles.offset = offset_;
  point_to(triangles.radiance, radiance_);
  triangles.two_sided = two_sided_;
  Array apart[9];
  EmittedRays out;
  Array* const arrays[9] = {&origin_[0],    &origin_[1], &origin_[2], &direction_[0], &direction_[1],
                            &direction_[2], &flux_[0],   &flux_[1],   &flux_[2]};
  float** const pointers[3] = {out.origin, out.direction, out.flux};
  for (std::size_t k = 0; k < 9; ++k) pointers[k / 3][k % 3] = others ? apart[k] : *arrays[k];
  emit_from_triangles(choices, triangles, out);
  if (!others) return;
  for (std::size_t i = 0; i < choices.count; ++i)
    if (kind_[i] == kTriangle)
      for (std::size_t k = 0; k < 9; ++k) (*arrays[k])[i] = apart[k][i];
}

void EmissionBlock::emit_other(const Scene& scene, std::size_t i) {
  const EmittedPhoton photon =
      sample_emission(scene, choice_[i], {place_[0][i], place_[1][i]}, {square_[0][i], square_[1][i]});
  const RGB flux = photon.flux * guide_weight_[i];
  light_[i] = photon.light;
  for (int k = 0; k < 3; ++k) {
    origin_[k][i] = photon.origin[k];
    direction_[k][i] = photon.direction[k];
    flux_[k][i] = flux[k];
  }
}

}  // namespace glowworm
