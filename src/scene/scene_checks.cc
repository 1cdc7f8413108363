#include "scene/scene_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/radiance_range.h"

namespace glowworm {

namespace {

constexpr const char* kImporterRemedy = "The scene file is inconsistent; export it again.";
/// Maximum cost of one texture lookup, in nodes: far above real textures, and low enough not to hang.
constexpr double kMaximalTextureCost = 4096;
constexpr int kMaximalTextureDepth = 256;
/// Mean number of times that light may scatter on its way out of a medium, and so a bound on a path's work.
constexpr float kMaxScatterings = 1e6f;
/// kMaxLight times this is still finite.
constexpr float kMaxFilmScale = 1e8f;

void check_size(std::size_t size, std::size_t wanted, const char* what) {
  if (size != wanted) throw Error(fmt::format("the scene has {} {}, but {} were expected", size, what, wanted));
}

/// Checks the arrays and indices of the scene's own triangles or of a mesh.
void check_arrays(const SceneDescription& d, const Geometry& g) {
  check_size(g.normals.size(), g.positions.size(), "normals");
  check_size(g.uvs.size(), g.positions.size(), "texture coordinates");
  if (!g.second_uvs.empty()) check_size(g.second_uvs.size(), g.positions.size(), "second texture coordinates");
  if (!g.colors.empty()) check_size(g.colors.size(), g.positions.size(), "vertex colours");
  check_size(g.material.size(), g.triangles.size(), "material indices");
  check_size(g.emission.size(), g.triangles.size(), "emission indices");
  for (std::size_t t = 0; t < g.triangles.size(); ++t) {
    for (const std::uint32_t vertex : g.triangles[t])
      if (vertex >= g.positions.size())
        throw Error(fmt::format("triangle {} refers to vertex {} of {}", t, vertex, g.positions.size()),
                    kImporterRemedy);
    if (g.material[t] >= d.materials.size())
      throw Error(fmt::format("triangle {} refers to material {} of {}", t, g.material[t], d.materials.size()),
                  kImporterRemedy);
    if (g.emission[t] != kNone && g.emission[t] >= d.emissions.size())
      throw Error(fmt::format("triangle {} refers to emission {} of {}", t, g.emission[t], d.emissions.size()),
                  kImporterRemedy);
  }
}

void check_instances(const SceneDescription& d) {
  const Geometry& g = d.geometry;
  for (const auto& mesh : g.meshes) {
    check_arrays(d, *mesh);
    const bool emits = std::any_of(mesh->emission.begin(), mesh->emission.end(), [](auto e) { return e != kNone; });
    if (mesh->triangles.empty() || emits || !mesh->instances.empty())
      throw Error("a mesh of instances is empty, emits light or has instances itself", kImporterRemedy);
  }
  std::size_t next = g.triangles.size();
  for (const Instance& instance : g.instances) {
    if (instance.mesh >= g.meshes.size() || !is_placeable(instance.to_world) || instance.first != next)
      throw Error(
          fmt::format("instance {} has an invalid mesh, transform or triangle number", &instance - g.instances.data()),
          kImporterRemedy);
    next += g.meshes[instance.mesh]->triangles.size();
  }
}

void check_geometry(const SceneDescription& d) {
  const Geometry& g = d.geometry;
  if (g.triangles.empty() && g.instances.empty())
    throw Error(fmt::format("the scene{} has no triangles", d.name.empty() ? "" : " \"" + d.name + "\""),
                "Check that the file holds meshes, and that they are not all of a kind that is not supported.");
  check_arrays(d, g);
  check_instances(d);
  std::size_t v = 0;
  g.for_each_position([&](const Vec3& p) {
    if (!is_within_bounds(p)) check_within_bounds(p, fmt::format("vertex {}", v));
    ++v;
  });
  const float size = length(g.bounds().diagonal());
  if (size < kMinSceneSize)
    throw Error(fmt::format("the scene is {:g} m across, but its size must be at least {:g} m", size, kMinSceneSize),
                "Scale the scene up.");
}

void check_textures(const std::vector<TextureNode>& textures) {
  for (std::size_t i = 0; i < textures.size(); ++i) {
    const TextureNode& node = textures[i];
    if (node.kind == TextureKind::image && !node.image)
      throw Error(fmt::format("texture {} has no image", i), kImporterRemedy);
    for (const std::uint32_t child : {node.child_a, node.child_b, node.child_amount})
      if (child != kNone && child >= i)
        throw Error(fmt::format("texture {} refers to texture {}, which does not stand before it", i, child),
                    "Textures must not refer to themselves.");
  }
  std::vector<TextureCost> costs;
  measure_textures(textures, costs);
  for (std::size_t i = 0; i < costs.size(); ++i)
    if (!costs[i].is_allowed())
      throw Error(
          fmt::format("texture {} is nested too deeply: {} levels, {} nodes", i, costs[i].levels, costs[i].nodes),
          "Combine its parts into an image.");
}

void check_texture_index(const SceneDescription& d, std::uint32_t texture, const std::string& owner) {
  if (texture != kNone && texture >= d.textures.size())
    throw Error(fmt::format("{} refers to texture {} of {}", owner, texture, d.textures.size()), kImporterRemedy);
}

/// Follows mixes from `material`; `state`: 0 new, 1 on the path, 2 done.
void check_mix(const SceneDescription& d, std::uint32_t material, std::vector<char>& state, int depth) {
  const Material& m = d.materials[material];
  if (m.kind != MaterialKind::mix || state[material] == 2) return;
  if (state[material] == 1 || depth > kMaximalTextureDepth)
    throw Error(fmt::format("material \"{}\" is mixed with itself or nested too deeply", m.name),
                "Mix only materials that are defined before.");
  state[material] = 1;
  for (const std::uint32_t part : {m.mix_a, m.mix_b}) {
    if (part >= d.materials.size())
      throw Error(fmt::format("material \"{}\" mixes material {} of {}", m.name, part, d.materials.size()),
                  kImporterRemedy);
    check_mix(d, part, state, depth + 1);
  }
  state[material] = 2;
}

void check_materials(const SceneDescription& d) {
  std::vector<char> state(d.materials.size(), 0);
  for (std::size_t i = 0; i < d.materials.size(); ++i) {
    const Material& m = d.materials[i];
    for (const ColorInput* input : color_inputs(m))
      check_texture_index(d, input->texture, fmt::format("material \"{}\"", m.name));
    for (const FloatInput* input : float_inputs(m))
      check_texture_index(d, input->texture, fmt::format("material \"{}\"", m.name));
    check_mix(d, static_cast<std::uint32_t>(i), state, 0);
    if (m.kind == MaterialKind::measured && !m.measured)
      throw Error(fmt::format("material \"{}\" has no matrices", m.name), kImporterRemedy);
  }
  for (const Emission& e : d.emissions)
    check_texture_index(d, e.radiance.texture, fmt::format("emission \"{}\"", e.name));
}

/// @param what names the light
void check_brightness(RGB value, float most, const std::string& what) {
  const auto numbers = [&] { return fmt::format("({:g}, {:g}, {:g})", value.r, value.g, value.b); };
  if (!is_finite(value))
    throw Error(fmt::format("{} has values that are not finite: {}", what, numbers()), kImporterRemedy);
  // A component may be negative: spectral colours lie outside the triangle of red, green and blue.
  if (luminance(value) < 0)
    throw Error(fmt::format("{} is negative: {}", what, numbers()), "Give it a positive value.");
  if (std::max({std::abs(value.r), std::abs(value.g), std::abs(value.b)}) > most)
    throw Error(fmt::format("{} is brighter than {:g}: {}", what, most, numbers()), "Give it a smaller value.");
}

void check_medium_index(const SceneDescription& d, std::uint32_t medium, const std::string& owner) {
  if (medium != kNone && medium >= d.media.size())
    throw Error(fmt::format("{} refers to medium {} of {}", owner, medium, d.media.size()), kImporterRemedy);
}

void check_media(const SceneDescription& d) {
  for (const Material& m : d.materials) {
    for (const std::uint32_t side : {m.inside, m.outside})
      if (side != kUnnamed) check_medium_index(d, side, fmt::format("material \"{}\"", m.name));
  }
  check_medium_index(d, d.ambient_medium, "the scene");
  const float size = length(d.geometry.bounds().diagonal());
  for (const Medium& medium : d.media) check_medium(medium, size);
}

}  // namespace

bool TextureCost::is_allowed() const { return nodes <= kMaximalTextureCost && levels <= kMaximalTextureDepth; }

void measure_textures(const std::vector<TextureNode>& textures, std::vector<TextureCost>& costs) {
  for (std::size_t i = costs.size(); i < textures.size(); ++i) {
    TextureCost cost;
    for (const std::uint32_t child : {textures[i].child_a, textures[i].child_b, textures[i].child_amount}) {
      if (child == kNone) continue;
      cost.nodes += costs[child].nodes;
      cost.levels = std::max(cost.levels, costs[child].levels + 1);
    }
    costs.push_back(cost);
  }
}

bool is_within_bounds(Vec3 p) {
  // NaN compares as false.
  return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate && std::abs(p.z) <= kMaxCoordinate;
}

void check_within_bounds(Vec3 p, const std::string& what) {
  if (is_within_bounds(p)) return;
  throw Error(fmt::format("{} is at ({:g}, {:g}, {:g}), but a scene may reach to {:g} m only", what, p.x, p.y, p.z,
                          kMaxCoordinate),
              is_finite(p) ? "Scale the scene down." : kImporterRemedy);
}

void check_lights(const SceneDescription& d) {
  for (const Light& light : d.lights) {
    const std::string what = fmt::format("light \"{}\"", light.name);
    if (light.kind == LightKind::luminaire && !light.table)
      throw Error(fmt::format("{} has no table of intensities", what), kImporterRemedy);
    check_brightness(light.kind == LightKind::luminaire ? light.intensity * light.table->greatest() : light.intensity,
                     kMaxLight, what);
    check_within_bounds(light.position, what);
    if (!is_finite(light.direction))
      throw Error(fmt::format("{} has values that are not finite", what), kImporterRemedy);
    if (light.kind != LightKind::point && length_squared(light.direction) == 0)
      throw Error(fmt::format("{} has no direction", what), kImporterRemedy);
    if (light.kind == LightKind::luminaire && !(length_squared(cross(light.direction, light.right)) > 0))
      throw Error(fmt::format("{} aims along its own right side", what), kImporterRemedy);
  }
  for (const Emission& e : d.emissions)
    check_brightness(e.radiance.value, kMaxRadiance, fmt::format("emission \"{}\"", e.name));
  if (!d.environment) return;
  const Environment& e = *d.environment;
  const std::string what = fmt::format("environment \"{}\"", e.name);
  check_brightness(e.scale, kMaxLight, what);
  if (e.width < 0 || e.height < 0 ||
      e.pixels.size() != static_cast<std::size_t>(e.width) * static_cast<std::size_t>(e.height))
    throw Error(fmt::format("{} has {} pixels, but {} x {} were expected", what, e.pixels.size(), e.width, e.height));
  if (!(std::abs(e.to_world.determinant()) > 0) || !std::isfinite(e.to_world.determinant()))
    throw Error(fmt::format("{} has a transform without an inverse", what), kImporterRemedy);
}

void check_dimness(const SceneDescription& d, float radius) {
  float brightest = 0;
  for (const Emission& e : d.emissions) brightest = std::max(brightest, max_component(e.radiance.value));
  // What a light without extent sends to a distance of a metre, or to the far end of a smaller scene.
  for (const Light& light : d.lights) {
    const float most = max_component(light.intensity) * (light.table ? light.table->greatest() : 1);
    const float squared = light.kind == LightKind::directional ? 1.0f : std::min(1.0f, radius * radius);
    brightest = std::max(brightest, most / squared);
  }
  if (d.environment)
    for (const RGB& texel : d.environment->pixels)
      brightest = std::max(brightest, max_component(texel * d.environment->scale));
  if (brightest > 0 && brightest < kMinRadiance)
    throw Error(fmt::format("the brightest light has {:g} W sr^-1 m^-2; pictures resolve light of {:g} or more",
                            brightest, kMinRadiance),
                "Multiply all lights by one factor, and divide the picture by it.");
}

void check_medium(const Medium& m, float size) {
  const std::string what = fmt::format("medium \"{}\"", m.name);
  const std::pair<const char*, RGB> colors[] = {
      {"sigma_a", m.sigma_a}, {"sigma_s", m.sigma_s}, {"emission", m.emission}};
  for (const auto& [name, c] : colors)
    if (!is_finite(c) || !(std::min({c.r, c.g, c.b}) >= 0))
      throw Error(fmt::format("{} has a {} of ({:g}, {:g}, {:g})", what, name, c.r, c.g, c.b),
                  "Give finite numbers of 0 or more.");
  if (!(m.g > -1 && m.g < 1))
    throw Error(fmt::format("{} has g = {:g}", what, m.g), "The mean cosine of scattering lies between -1 and 1.");
  const float determinant = m.to_medium.determinant();
  if (!(std::abs(determinant) > 0) || !std::isfinite(determinant) || !is_finite(m.to_medium.translation))
    throw Error(fmt::format("{} has a transform without an inverse", what), "A scale of 0?");
  if (m.grid && !m.bounds) throw Error(fmt::format("{} has a grid without bounds", what), kImporterRemedy);
  if (m.bounds) {
    const Vec3 sides = m.bounds->diagonal();
    if (!is_within_bounds(m.bounds->min) || !is_within_bounds(m.bounds->max) ||
        !(std::min({sides.x, sides.y, sides.z}) > 0))
      throw Error(fmt::format("{} fills a box of {:g} x {:g} x {:g}", what, sides.x, sides.y, sides.z),
                  "Give it a box with a volume.");
    size = std::min(size, length(sides) / std::cbrt(std::abs(determinant)));
  }
  check_brightness(m.emission * (m.grid ? m.grid->greatest().emission : RGB(1.0f)), kMaxRadiance, what);
  const RGB most = m.grid ? m.sigma_s * m.grid->greatest().sigma_s : m.sigma_s;
  for (int c = 0; c < 3; ++c) {
    const float until_absorbed = m.sigma_a[c] > 0 ? m.sigma_s[c] / m.sigma_a[c] : HUGE_VALF;
    if (std::min(most[c] * size, until_absorbed) <= kMaxScatterings && greatest_extinction(m) <= kMaxLight) continue;
    throw Error(fmt::format("{} has an extinction of {:g} m^-1, too much for a size of {:g} m", what,
                            greatest_extinction(m), size),
                "Give it smaller coefficients, or replace it by a diffuse surface.");
  }
}

void check_cameras(const SceneDescription& d) {
  for (const Camera& camera : d.cameras) {
    const std::string what = fmt::format("camera \"{}\"", camera.name);
    const float determinant = camera.to_world.determinant();
    if (!(std::abs(determinant) > 0) || !std::isfinite(determinant))
      throw Error(fmt::format("{} has a transform without an inverse", what), kImporterRemedy);
    check_within_bounds(camera.to_world.translation, what);
    if (!(camera.half_extent > 0) || !std::isfinite(camera.half_extent))
      throw Error(fmt::format("{} has no field of view", what), kImporterRemedy);
    float widest = 1;
    for (const float side : camera.window) widest = std::max(widest, std::isfinite(side) ? std::abs(side) : HUGE_VALF);
    const std::pair<const char*, float> lengths[] = {{"lens", camera.lens_radius},
                                                     {"focal distance", camera.focal_distance},
                                                     {"picture plane", widest * camera.half_extent}};
    for (const auto& [name, length] : lengths)
      if (!(std::abs(length) <= kMaxCoordinate))
        throw Error(fmt::format("{} has a {} of {:g} m; at most {:g} m can be", what, name, length, kMaxCoordinate),
                    "Scale the scene down.");
  }
}

void check_description(const SceneDescription& description) {
  check_geometry(description);
  check_textures(description.textures);
  check_materials(description);
  check_media(description);
  check_lights(description);
  check_cameras(description);
  if (!(std::abs(description.film.scale) <= kMaxFilmScale))
    throw Error(fmt::format("the film multiplies radiance by {:g}", description.film.scale),
                "Give its sensor another exposure time or ISO.");
}

}  // namespace glowworm
