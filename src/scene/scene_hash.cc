#include "scene/scene_hash.h"

#include <map>

#include "bsdf/measured.h"
#include "core/content_hash.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

void add(ContentHash& hash, const ColorInput& input) { hash.add(input); }

void add(ContentHash& hash, const FloatInput& input) {
  hash.add(input.value);
  hash.add(input.texture);
  hash.add(input.channel);
}

void add(ContentHash& hash, const Transform& map) { hash.add(map); }

// If a structure gets a new member, hash it, then update the size.
static_assert(sizeof(ColorInput) == 16 && sizeof(FloatInput) == 12 && sizeof(Transform) == 48);
static_assert(sizeof(Material) == 448 && sizeof(TextureNode) == 72 && sizeof(Emission) == 104);
static_assert(sizeof(Light) == 136 && sizeof(Environment) == 208 && sizeof(Camera) == 112);
static_assert(sizeof(Geometry) == 12 * sizeof(std::vector<Vec3>) + sizeof(std::size_t) && sizeof(Instance) == 60);

void add(ContentHash& hash, const Material& m) {
  hash.add(m.kind);
  for (const ColorInput* input : color_inputs(m)) add(hash, *input);
  for (const FloatInput* input : float_inputs(m)) add(hash, *input);
  hash.add(m.eta);
  hash.add(m.k);
  hash.add(m.use_reflectance);
  hash.add(m.ior);
  hash.add(m.coat_thickness);
  hash.add(m.coat_bounces);
  hash.add(m.thin);
  hash.add(m.single_sided);
  hash.add(m.unseen);
  hash.add(m.mix_a);
  hash.add(m.mix_b);
  hash.add(m.alpha_cutoff);
  for (const float number :
       {m.normal_scale, m.coat_normal_scale, m.anisotropy_rotation, m.iridescence_ior, m.least_film, m.dispersion})
    hash.add(number);
  hash.add(m.inside);
  hash.add(m.outside);
  hash.add(m.measured ? m.measured->hash() : 0);
  hash.add(m.measured_up);
}

void add(ContentHash& hash, const Medium& m) {
  for (const RGB& color : {m.sigma_a, m.sigma_s, m.emission}) hash.add(color);
  hash.add(m.g);
  add(hash, m.to_medium);
  hash.add(m.bounds.has_value());
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
  hash.add(width);
  hash.add(image.height());
  hash.add(image.has_alpha());
  hash.add_array(std::span<const std::uint64_t>(parts));
  // Lookups outside the unit square depend on the wrap mode.
  for (const float t : {-1.3f, -0.3f, 1.3f, 2.3f})
    for (const Vec2 uv : {Vec2{t, 0.4f}, Vec2{0.4f, t}}) hash.add(image.color(uv));
  return hash.value();
}

void add(ContentHash& hash, const TextureNode& t) {
  hash.add(t.kind);
  hash.add(t.value);
  hash.add(t.from_alpha);
  hash.add(t.invert);
  hash.add(t.second_uv);
  hash.add(t.uv_scale);
  hash.add(t.uv_offset);
  hash.add(t.uv_rotation);
  for (const std::uint32_t child : {t.child_a, t.child_b, t.child_amount}) hash.add(child);
}

void add(ContentHash& hash, const Light& l) {
  hash.add(l.kind);
  hash.add(l.intensity);
  hash.add(l.position);
  hash.add(l.direction);
  hash.add(l.cos_inner);
  hash.add(l.cos_outer);
  hash.add(l.falloff);
  hash.add(l.right);
  hash.add(l.table ? l.table->hash() : 0);
}

void add(ContentHash& hash, const Environment& e) {
  hash.add(e.scale);
  hash.add(e.width);
  hash.add(e.height);
  hash.add_array(std::span(e.pixels));
  hash.add(e.mapping);
  add(hash, e.to_world);
  hash.add(e.sky.has_value());
  if (e.sky) hash.add(*e.sky);
  // Their function has no bytes to hash; a division into as many parts is taken to be the same.
  hash.add(e.parts ? e.parts->count : 1);
  hash.add(e.stands_in);
}

std::uint64_t hash_geometry(const Geometry& g) {
  ContentHash hash;
  hash.add_array(std::span(g.positions));
  hash.add_array(std::span(g.normals));
  hash.add_array(std::span(g.uvs));
  hash.add_array(std::span(g.second_uvs));
  hash.add_array(std::span(g.colors));
  hash.add_array(std::span(g.triangles));
  hash.add_array(std::span(g.material));
  hash.add_array(std::span(g.emission));
  // Names of objects do not affect samples.
  for (const ObjectStart& object : g.objects) hash.add(object.first_triangle);
  for (const auto& mesh : g.meshes) hash.add(hash_geometry(*mesh));
  hash.add_array(std::span(g.instances));
  return hash.value();
}

std::uint64_t hash_materials(const Scene& scene) {
  ContentHash hash;
  for (const Material& material : scene.materials()) add(hash, material);
  for (const Medium& medium : scene.media()) add(hash, medium);
  hash.add(scene.ambient_medium());
  std::map<const TextureImage*, std::uint64_t> images;
  for (const TextureNode& node : scene.textures()) {
    add(hash, node);
    if (!node.image) continue;
    const auto [image, is_new] = images.try_emplace(node.image.get(), 0);
    if (is_new) image->second = hash_image(*node.image);
    hash.add(image->second);
  }
  return hash.value();
}

std::uint64_t hash_lights(const Scene& scene) {
  ContentHash hash;
  for (const Emission& emission : scene.emissions()) {
    add(hash, emission.radiance);
    hash.add(emission.two_sided);
    if (!emission.profile) continue;
    hash.add(emission.profile->hash());
    hash.add(emission.aim);
    hash.add(emission.right);
  }
  for (const Light& light : scene.lights()) add(hash, light);
  hash.add(scene.environment().has_value());
  if (scene.environment()) add(hash, *scene.environment());
  return hash.value();
}

}  // namespace

std::uint64_t hash_camera(const Camera& c) {
  ContentHash hash;
  hash.add(c.kind);
  add(hash, c.to_world);
  hash.add(c.half_extent);
  hash.add(c.window);
  hash.add(c.lens_radius);
  hash.add(c.focal_distance);
  return hash.value();
}

SceneHash hash_scene(const Scene& scene, const Camera& camera) {
  return {hash_geometry(scene.geometry()), hash_materials(scene), hash_lights(scene), hash_camera(camera)};
}

}  // namespace glowworm
