#include "scene/scene_hash.h"

#include <map>

#include "bsdf/measured.h"
#include "core/content_hash.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

/// Adds values without padding, one after another.
template <typename... Values>
void add_all(ContentHash& hash, const Values&... values) {
  (hash.add(values), ...);
}

void add(ContentHash& hash, const FloatInput& input) { add_all(hash, input.value, input.texture, input.channel); }

// If a structure gets a new member, hash it, then update the size.
static_assert(sizeof(ColorInput) == 16 && sizeof(FloatInput) == 12 && sizeof(Transform) == 48);
static_assert(sizeof(Material) == 448 && sizeof(TextureNode) == 72 && sizeof(Emission) == 104);
static_assert(sizeof(Light) == 136 && sizeof(Environment) == 208 && sizeof(Camera) == 120);
static_assert(sizeof(Geometry) == 12 * sizeof(std::vector<Vec3>) + sizeof(std::size_t) && sizeof(Instance) == 60);

void add(ContentHash& hash, const Material& m) {
  hash.add(m.kind);
  for (const ColorInput* input : color_inputs(m)) hash.add(*input);
  for (const FloatInput* input : float_inputs(m)) add(hash, *input);
  add_all(hash, m.eta, m.k, m.use_reflectance, m.ior, m.coat_thickness, m.coat_bounces, m.thin, m.single_sided,
          m.unseen, m.mix_a, m.mix_b, m.alpha_cutoff, m.normal_scale, m.coat_normal_scale, m.anisotropy_rotation,
          m.iridescence_ior, m.least_film, m.dispersion, m.inside, m.outside, m.measured ? m.measured->hash() : 0,
          m.measured_up);
}

void add(ContentHash& hash, const Medium& m) {
  add_all(hash, m.sigma_a, m.sigma_s, m.emission, m.g, m.to_medium, m.bounds.has_value());
  if (m.bounds) hash.add(*m.bounds);
  hash.add(m.grid != nullptr);
  if (!m.grid) return;
  const MediumGridValues& values = m.grid->values();
  hash.add(values.size);
  hash.add_array(std::span(values.density));
  for (const std::vector<RGB>* array : {&values.sigma_a, &values.sigma_s, &values.emission})
    hash.add_array(std::span<const RGB>(*array));
}

/// Hashes all texels, looked up at their centres.
std::uint64_t hash_image(const TextureImage& image) {
  constexpr std::size_t kRowsAtOnce = 16;
  const int width = image.width();
  const auto rows = static_cast<std::size_t>(image.height());
  std::vector<std::uint64_t> parts((rows + kRowsAtOnce - 1) / kRowsAtOnce);
  parallel_for(0, rows, kRowsAtOnce, [&](std::size_t first, std::size_t last) {
    ContentHash hash;
    for (std::size_t row = first; row < last; ++row)
      for (int column = 0; column < width; ++column) {
        const Vec2 uv{(static_cast<float>(column) + 0.5f) / static_cast<float>(width),
                      1 - (static_cast<float>(row) + 0.5f) / static_cast<float>(rows)};
        hash.add(image.color(uv));
        if (image.has_alpha()) hash.add(image.alpha(uv));
      }
    parts[first / kRowsAtOnce] = hash.value();
  });
  ContentHash hash;
  add_all(hash, width, image.height(), image.has_alpha());
  hash.add_array(std::span<const std::uint64_t>(parts));
  // Lookups outside the unit square depend on the wrap mode.
  for (const float t : {-1.3f, -0.3f, 1.3f, 2.3f})
    for (const Vec2 uv : {Vec2{t, 0.4f}, Vec2{0.4f, t}}) hash.add(image.color(uv));
  return hash.value();
}

void add(ContentHash& hash, const TextureNode& t) {
  add_all(hash, t.kind, t.value, t.from_alpha, t.invert, t.second_uv, t.uv_scale, t.uv_offset, t.uv_rotation, t.child_a,
          t.child_b, t.child_amount);
}

void add(ContentHash& hash, const Light& l) {
  add_all(hash, l.kind, l.intensity, l.position, l.direction, l.cos_inner, l.cos_outer, l.falloff, l.right,
          l.table ? l.table->hash() : 0);
}

void add(ContentHash& hash, const Environment& e) {
  add_all(hash, e.scale, e.width, e.height);
  hash.add_array(std::span(e.pixels));
  add_all(hash, e.mapping, e.to_world, e.sky.has_value());
  if (e.sky) hash.add(*e.sky);
  // Their function has no bytes to hash; a division into as many parts is taken to be the same.
  add_all(hash, e.parts ? e.parts->count : 1, e.stands_in);
}

std::uint64_t hash_geometry(const Geometry& g) {
  ContentHash hash;
  const auto add_arrays = [&](const auto&... arrays) { (hash.add_array(std::span(arrays)), ...); };
  add_arrays(g.positions, g.normals, g.uvs, g.second_uvs, g.colors, g.triangles, g.material, g.emission);
  // Names of objects do not affect samples.
  for (const ObjectStart& object : g.objects) hash.add(object.first_triangle);
  for (const auto& mesh : g.meshes) hash.add(hash_geometry(*mesh));
  hash.add_array(std::span(g.instances));
  return hash.value();
}

/// @param hash_of hash_of(image)
template <typename HashOf>
std::uint64_t hash_materials(const Scene& scene, const HashOf& hash_of) {
  ContentHash hash;
  for (const Material& material : scene.materials()) add(hash, material);
  for (const Medium& medium : scene.media()) add(hash, medium);
  hash.add(scene.ambient_medium());
  for (const TextureNode& node : scene.textures()) {
    add(hash, node);
    if (node.image) hash.add(hash_of(*node.image));
  }
  return hash.value();
}

std::uint64_t hash_materials(const Scene& scene) {
  std::map<const TextureImage*, std::uint64_t> images;
  return hash_materials(scene, [&](const TextureImage& shown) {
    const auto [image, is_new] = images.try_emplace(&shown, 0);
    if (is_new) image->second = hash_image(shown);
    return image->second;
  });
}

std::uint64_t hash_lights(const Scene& scene) {
  ContentHash hash;
  for (const Emission& emission : scene.emissions()) {
    add_all(hash, emission.radiance, emission.two_sided);
    if (emission.profile) add_all(hash, emission.profile->hash(), emission.aim, emission.right);
  }
  for (const Light& light : scene.lights()) add(hash, light);
  hash.add(scene.environment().has_value());
  if (scene.environment()) add(hash, *scene.environment());
  return hash.value();
}

}  // namespace

std::uint64_t hash_camera(const Camera& c) {
  ContentHash hash;
  add_all(hash, c.kind, c.to_world, c.half_extent, c.window, c.aspect, c.lens_radius, c.focal_distance);
  return hash.value();
}

std::uint64_t hash_look(const Scene& scene) {
  return hash_materials(scene, [](const TextureImage& image) { return image.identity(); });
}

SceneHash hash_scene(const Scene& scene, const Camera& camera) {
  return {hash_geometry(scene.geometry()), hash_materials(scene), hash_lights(scene), hash_camera(camera)};
}

}  // namespace glowworm
