// Pictures of instances: as of copies of their meshes.
#include <gtest/gtest.h>

#include "builtin/builtin.h"
#include "builtin/mesh_builder.h"
#include "render/render_testing.h"
#include "scene/instance_parts.h"

namespace glowworm {
namespace {

/// A knobbly shape of one material with smooth normals, around the origin.
Geometry shape(std::uint32_t material, bool smooth) {
  SceneDescription source;
  MeshBuilder builder(source.geometry);
  builder.set_material(material);
  builder.sphere({0, 0, 0}, 0.1f, 12, 8);
  builder.box({-0.13f, -0.02f, -0.02f}, {-0.08f, 0.02f, 0.03f});
  Geometry out;
  append_mesh(out, source.geometry, "shape", kNone, kNone);
  if (!smooth) std::fill(out.normals.begin(), out.normals.end(), Vec3{0, 0, 0});
  return out;
}

/// Places them in a cube of that half side, mirrored every second time. The places are those of nested transforms.
void scatter(SceneDescription& d, const Geometry& mesh, std::uint32_t count, float reach, std::uint32_t seed = 0) {
  const std::uint32_t front = add_shared_mesh(d, mesh), back = add_shared_mesh(d, wound_back(mesh));
  for (std::uint32_t i = 100 * seed, placed = 0; placed < count; ++i) {
    const bool mirrors = placed % 2;
    const Transform place = random_place(i, false, 0.7f, reach) * random_place(1000 + i, mirrors, 0.7f, 0.05f);
    if (!is_placeable(place)) continue;
    add_places(d, mirrors ? back : front, {place});
    ++placed;
  }
}

/// Emission 1 and reflectance 1/2 make a radiance of 2, which white shapes leave as it is.
TEST(InstancesFurnace, IsAsBrightAsTheEmptyBox) {
  SceneDescription d = builtin_scene("furnace-box");
  d.materials.emplace_back().reflectance.value = RGB(1.0f);
  const auto white = static_cast<std::uint32_t>(d.materials.size() - 1);
  scatter(d, shape(white, false), 30, 0.3f);
  const Stage stage(d);
  for (const RenderSettings& settings : {by_path(12, 64), by_photons(12, 4, 16, 100'000, "blocked")}) {
    const Mean found = mean(stage.render(settings));
    for (const double v : found.value) EXPECT_NEAR(v / 2, 1, 0.006);
  }
}

/// The Cornell box with diffuse, glossy and mirroring instances.
SceneDescription furnished() {
  SceneDescription d = builtin_scene("cornell");
  const auto first = static_cast<std::uint32_t>(d.materials.size());
  d.materials.resize(first + 3);
  d.materials[first].reflectance.value = {0.2f, 0.5f, 0.7f};
  d.materials[first + 1].kind = MaterialKind::coated_diffuse;
  d.materials[first + 2].kind = MaterialKind::conductor;
  d.materials[first + 2].use_reflectance = true;
  const Box3 box = d.geometry.bounds();
  for (std::uint32_t kind = 0; kind < 3; ++kind) {
    const std::size_t before = d.geometry.instances.size();
    scatter(d, shape(first + kind, kind < 2), 8, 0.2f, kind);
    for (std::size_t i = before; i < d.geometry.instances.size(); ++i)
      d.geometry.instances[i].to_world.translation += box.center();
  }
  d.geometry.number_instances();
  return d;
}

double difference(const std::vector<RGB>& a, const std::vector<RGB>& b) {
  double sum = 0, all = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += std::abs(luminance(a[i]) - luminance(b[i]));
    all += luminance(b[i]);
  }
  return sum / all;
}

/// Light that came straight from lamps.
std::vector<RGB> direct_light(const Film& film) {
  std::vector<RGB> out = pixels(film);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = out[i] - film.radiance(i, true);
  return out;
}

/// Each bounce from a small shape enlarges the rounding between paths, so long paths differ like those of other seeds.
TEST(InstancesPicture, IsOfCopiesButForRounding) {
  const Stage kept(furnished()), copied(expanded(furnished()));
  RenderSettings photons = by_photons(16, 2, 16, 20'000, "blocked");
  RenderSettings map_alone = photons;
  map_alone.gather = 0;
  for (const RenderSettings& settings : {by_path(16, 16), photons, map_alone}) {
    RenderSettings other = settings;
    other.seed = 5;
    const Film a = kept.render(settings), b = copied.render(settings), c = copied.render(other);
    EXPECT_LT(difference(direct_light(a), direct_light(b)), 0.003);
    EXPECT_LT(difference(pixels(a), pixels(b)), 0.25 * difference(pixels(c), pixels(b)));
  }
}

}  // namespace
}  // namespace glowworm
