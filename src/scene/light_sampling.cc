#include "scene/light_sampling.h"

#include <algorithm>
#include <limits>

#include "core/offset_origin.h"
#include "core/warp.h"
#include "scene/environment.h"
#include "scene/light_power.h"

namespace glowworm {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

using Choice = LightSelector::Choice;

/// If a light has at least this probability, the number that chose it has enough digits left to choose a point on it.
constexpr float kMinStretchedProbability = 1.0f / 4096;

Choice choose_source(const Scene& scene, float u) {
  const auto sample = scene.light_power().sample(u);
  return {sample.index, sample.probability, sample.remapped};
}

const Emission& emission_of(const Scene& scene, std::uint32_t triangle) {
  return scene.emissions()[scene.geometry().emission[triangle]];
}

/// Density per steradian of a uniform choice by area, seen from a point; 0 if the point is behind the light.
/// @param scaled_normal length twice the area, m^2
/// @param direction unit, from the point to the light; @param distance metres
float triangle_solid_angle_pdf(Vec3 scaled_normal, bool two_sided, Vec3 direction, float distance) {
  // 1/A * d^2 / cos = 2 d^2 / |scaled . direction|, with |scaled| = 2 A.
  const float facing = -dot(scaled_normal, direction);
  if (!(facing > 0) && !(two_sided && facing < 0)) return 0;
  const float density = 2 * distance * distance / std::abs(facing);
  return std::isfinite(density) ? density : 0.0f;
}

LightSample sample_triangle(const Scene& scene, std::uint32_t triangle, Vec3 position, Vec2 u) {
  LightSample out;
  const DiffuseTriangle& placed = scene.diffuse_triangle(triangle);
  const Vec2 w = square_to_triangle(u);
  const Emission& emission = emission_of(scene, triangle);
  out.position = placed.corner + placed.edge[0] * w.x + placed.edge[1] * w.y;
  const Vec3 offset = out.position - position;
  out.distance = length(offset);
  out.direction = offset / out.distance;
  out.pdf =
      triangle_solid_angle_pdf(cross(placed.edge[0], placed.edge[1]), emission.two_sided, out.direction, out.distance);
  if (out.pdf == 0) return out;
  out.normal = face_forward(placed.normal, -out.direction);
  out.offset = placed.offset();
  out.radiance = mean_emission(scene, triangle, w);
  out.radiance *= relative_radiance(emission, -out.direction);
  return out;
}

LightSample sample_from_environment(const Environment& environment, const Distribution2D& distribution, Vec2 u) {
  LightSample out;
  out.direction = sample_environment_direction(environment, distribution, u);
  // Recomputed from the direction, as the other strategies of the heuristic compute it.
  const auto [radiance, pdf] = radiance_and_pdf(environment, distribution, out.direction);
  out.pdf = pdf;
  out.radiance = radiance;
  out.distance = kInfinity;
  return out;
}

/// Samples a direction by the intensity of a whole opening, and a place on the faces that shine there by their
/// projected area. All photons of the opening have one flux for each unit of probability. @param power of the chosen
/// triangle
EmittedPhoton emit_from_opening(const Scene& scene, const Emission& emission, RGB power, Vec2 u_position,
                                Vec2 u_direction) {
  EmittedPhoton out;
  out.direction =
      normalize(luminaire_axes(emission.right, emission.aim).to_world(emission.profile->sample(u_direction)));
  const auto projected = [&](std::uint32_t i) {
    const DiffuseTriangle& placed = scene.diffuse_triangle(emission.first_triangle + i);
    const float facing = dot(cross(placed.edge[0], placed.edge[1]), out.direction);
    return emission.two_sided ? std::abs(facing) : std::max(facing, 0.0f);
  };
  float all = 0;
  for (std::uint32_t i = 0; i < emission.triangle_count; ++i) all += projected(i);
  if (!(all > 0)) return {};
  float left = u_position.x * all;
  std::uint32_t chosen = 0;
  float share = 0;
  for (std::uint32_t i = 0; i < emission.triangle_count; ++i) {
    const float area = projected(i);
    if (!(area > 0)) continue;
    chosen = i;
    share = area;
    if (left < area) break;
    left -= area;
  }
  const std::uint32_t triangle = emission.first_triangle + chosen;
  const DiffuseTriangle& placed = scene.diffuse_triangle(triangle);
  const Vec2 w = square_to_triangle({std::clamp(left / share, 0.0f, kBelowOne), u_position.y});
  const Vec3 side = face_forward(placed.normal, out.direction);
  out.origin = offset_origin(placed.corner + placed.edge[0] * w.x + placed.edge[1] * w.y, side, placed.offset());
  out.flux = power;
  return out;
}

EmittedPhoton emit_from_triangle(const Scene& scene, std::uint32_t source, Vec2 u_position, Vec2 u_direction) {
  const std::uint32_t triangle = scene.emissive_triangles()[source];
  if (const Emission& whole = emission_of(scene, triangle); whole.profile)
    return emit_from_opening(scene, whole, scene.source_powers()[source], u_position, u_direction);
  const DiffuseTriangle& placed = scene.diffuse_triangle(triangle);
  const Vec2 w = square_to_triangle(u_position);
  const Emission& emission = emission_of(scene, triangle);
  const float doubled_area = dot(cross(placed.edge[0], placed.edge[1]), placed.normal);
  Vec3 n = placed.normal;
  float sides = 1;
  if (emission.two_sided) {
    sides = 2;
    const bool back = u_direction.x >= 0.5f;
    if (back) n = -n;
    u_direction.x = 2 * u_direction.x - (back ? 1.0f : 0.0f);
  }
  EmittedPhoton out;
  out.origin = offset_origin(placed.corner + placed.edge[0] * w.x + placed.edge[1] * w.y, n, placed.offset());
  out.direction = Frame::from_normal(n).to_world(square_to_cosine_hemisphere(u_direction));
  out.flux = mean_emission(scene, triangle, w) * (kPi * 0.5f * doubled_area * sides);
  return out;
}

/// Samples a direction of a spot in approximate proportion to its falloff; the flux compensates for the difference.
EmittedPhoton emit_from_spot(const Light& light, Vec2 u) {
  const float core = 1 - light.cos_inner, edge = (light.cos_inner - light.cos_outer) * mean_spot_falloff(light);
  const float core_share = core + edge > 0 ? core / (core + edge) : 1.0f;
  float weight = 1, cosine;
  if (u.x < core_share) {
    cosine = 1 - core * (u.x / core_share);
  } else {
    const float inside = (u.x - core_share) / (1 - core_share);
    // Powers of t: inverted exactly. Smoothstep t^2 (3 - 2t): sampled with density 2t.
    const bool smooth = light.falloff == SpotFalloff::smoothstep;
    const float t = smooth                                    ? std::sqrt(inside)
                    : light.falloff == SpotFalloff::quadratic ? std::cbrt(inside)
                                                              : std::pow(inside, 0.2f);
    if (smooth) weight = t * (3 - 2 * t);
    cosine = light.cos_outer + (light.cos_inner - light.cos_outer) * t;
  }
  const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine)), phi = 2 * kPi * u.y;
  EmittedPhoton out;
  out.origin = light.position;
  out.direction = Frame::from_normal(light.direction).to_world({sine * std::cos(phi), sine * std::sin(phi), cosine});
  out.flux = light_power(light, 0) * weight;
  return out;
}

/// Samples a point on the disc in front of the scene, perpendicular to `direction`. The flux is `irradiance` times the
/// disc's area.
EmittedPhoton emit_from_afar(const Scene& scene, Vec3 direction, RGB irradiance, Vec2 u) {
  const auto& [center, radius] = scene.lit_sphere();
  const Vec2 disk = square_to_disk(u) * radius;
  EmittedPhoton out;
  out.origin = center + Frame::from_normal(direction).to_world({disk.x, disk.y, -radius});
  out.direction = direction;
  out.flux = irradiance * (kPi * radius * radius);
  return out;
}

EmittedPhoton emit_from_light(const Scene& scene, const Light& light, Vec2 u_position, Vec2 u_direction) {
  if (light.kind == LightKind::directional) return emit_from_afar(scene, light.direction, light.intensity, u_position);
  if (light.kind == LightKind::spot) return emit_from_spot(light, u_direction);
  EmittedPhoton out;
  out.origin = light.position;
  if (light.kind == LightKind::luminaire) {
    out.direction = normalize(luminaire_axes(light.right, light.direction).to_world(light.table->sample(u_direction)));
  } else {
    out.direction = square_to_sphere(u_direction);
  }
  out.flux = light_power(light, 0);
  return out;
}

/// Samples a place of a medium's volume, and a direction.
EmittedPhoton emit_from_medium(const Scene& scene, const MediumEmission& emission, float u_block, Vec2 u_position,
                               Vec2 u_direction) {
  const MediumEmission::Start start =
      emission.sample(scene.media()[emission.medium()], {u_block, u_position.x, u_position.y}, u_direction);
  EmittedPhoton out;
  out.origin = start.position;
  out.direction = start.direction;
  out.flux = start.flux;
  return out;
}

EmittedPhoton emit_from_environment(const Scene& scene, Vec2 u_position, Vec2 u_direction) {
  const EnvironmentDirection sample =
      sample_environment(*scene.environment(), scene.environment_distribution(), u_direction);
  if (sample.value.pdf == 0) return {};
  return emit_from_afar(scene, -sample.direction, sample.value.radiance / sample.value.pdf, u_position);
}

}  // namespace

LightSample sample_delta(const Light& light, Vec3 position) {
  LightSample out;
  out.delta = true;
  if (light.kind == LightKind::directional) {
    out.pdf = 1;
    out.direction = -light.direction;
    out.distance = kInfinity;
    out.radiance = light.intensity;
    return out;
  }
  const Vec3 offset = light.position - position;
  const float squared = length_squared(offset);
  out.distance = std::sqrt(squared);
  out.direction = offset / out.distance;
  out.position = light.position;
  const float share = light.kind == LightKind::spot        ? spot_falloff(light, -dot(out.direction, light.direction))
                      : light.kind == LightKind::luminaire ? table_intensity(light, -out.direction)
                                                           : 1.0f;
  if (share == 0 || !(squared > 0)) return out;
  out.pdf = 1;
  out.radiance = light.intensity * (share / squared);
  return out;
}

LightSample sample_light_of(const Scene& scene, std::uint32_t source, Vec3 position, Vec2 u) {
  const std::size_t triangles = scene.emissive_triangles().size();
  LightSample out = source < triangles ? sample_triangle(scene, scene.emissive_triangles()[source], position, u)
                    : source < triangles + scene.lights().size()
                        ? sample_delta(scene.lights()[source - triangles], position)
                        : sample_from_environment(*scene.environment(), scene.environment_distribution(), u);
  out.random = u;
  return out;
}

RGB mean_emission(const Scene& scene, std::uint32_t triangle, Vec2 barycentric) {
  const TexturePoint at = texture_point(scene.geometry(), triangle, barycentric);
  return evaluate(scene.textures(), emission_of(scene, triangle).radiance, at) * coverage(scene, triangle, at);
}

LightSample sample_light(const Scene& scene, Vec3 position, float u_light, Vec2 u) {
  LightSelector::AtPoint lights(scene.light_selector(), position);
  return sample_light(scene, position, lights, u_light, u);
}

LightSample sample_light(const Scene& scene, Vec3 position, LightSelector::AtPoint& lights, float u_light, Vec2 u) {
  const Choice choice = lights.choose(u_light);
  if (!(choice.probability > 0)) return {};
  if (choice.probability > kMinStretchedProbability) u.x = choice.remapped;
  LightSample out = sample_light_of(scene, choice.source, position, u);
  out.pdf *= choice.probability;
  out.source =
      choice.source < scene.first_environment_source() ? choice.source : environment_source(scene, out.direction);
  return out;
}

LightSample sample_directional(const Scene& scene, Vec3 position, float u) {
  const Choice choice = scene.light_selector().choose_directional(u);
  LightSample out = sample_light_of(scene, choice.source, position, {u, 0});
  out.pdf *= choice.probability;
  out.source = choice.source;
  return out;
}

float light_pdf(const Scene& scene, Vec3 position, const SurfacePoint& on_light) {
  const std::uint32_t source = scene.emissive_index(on_light.triangle);
  if (source == kNone) return 0;
  const Vec3 offset = on_light.position - position;
  const float distance = length(offset);
  const float density =
      triangle_solid_angle_pdf(scene.geometry().scaled_normal(on_light.triangle),
                               emission_of(scene, on_light.triangle).two_sided, offset / distance, distance);
  return density > 0 ? scene.light_selector().probability(position, source) * density : 0.0f;
}

float environment_pdf(const Scene& scene, Vec3 position, Vec3 direction) {
  if (!scene.environment()) return 0;
  return scene.light_selector().probability(position, scene.first_environment_source()) *
         radiance_and_pdf(*scene.environment(), scene.environment_distribution(), direction).pdf;
}

std::uint32_t environment_source(const Scene& scene, Vec3 direction) {
  const EnvironmentParts* const parts = scene.environment() ? scene.environment()->parts.get() : nullptr;
  return scene.first_environment_source() + (parts ? parts->part_of(direction) : 0);
}

RGB environment_radiance(const Scene& scene, Vec3 direction) {
  return scene.environment() ? radiance(*scene.environment(), direction) : RGB(0.0f);
}

EmittedPhoton sample_emission(const Scene& scene, float u_light, Vec2 u_position, Vec2 u_direction) {
  if (!(scene.light_power().total() > 0)) return {};
  const Choice choice = choose_source(scene, u_light);
  const std::size_t triangles = scene.emissive_triangles().size();
  EmittedPhoton out;
  if (choice.source < triangles)
    out = emit_from_triangle(scene, choice.source, u_position, u_direction);
  else if (choice.source < triangles + scene.lights().size())
    out = emit_from_light(scene, scene.lights()[choice.source - triangles], u_position, u_direction);
  else if (const MediumEmission* const medium = scene.medium_of_source(choice.source))
    out = emit_from_medium(scene, *medium, choice.remapped, u_position, u_direction);
  else
    out = emit_from_environment(scene, u_position, u_direction);
  out.flux *= 1 / choice.probability;
  out.light =
      choice.source < scene.first_environment_source() ? choice.source : environment_source(scene, -out.direction);
  return out;
}

std::string light_source_name(const Scene& scene, std::uint32_t source) {
  const std::size_t triangles = scene.emissive_triangles().size();
  if (source < triangles) {
    const Emission& emission = emission_of(scene, scene.emissive_triangles()[source]);
    return emission.name.empty() ? "area light" : emission.name;
  }
  if (source < triangles + scene.lights().size()) {
    const Light& light = scene.lights()[source - triangles];
    if (!light.name.empty()) return light.name;
    return light.kind == LightKind::point       ? "point light"
           : light.kind == LightKind::spot      ? "spot light"
           : light.kind == LightKind::luminaire ? "luminaire"
                                                : "directional light";
  }
  if (const MediumEmission* const emission = scene.medium_of_source(source)) {
    const std::string& name = scene.media()[emission->medium()].name;
    return name.empty() ? "medium" : name;
  }
  return scene.environment()->name.empty() ? "environment" : scene.environment()->name;
}

}  // namespace glowworm
