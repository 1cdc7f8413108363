// Notes on materials: caustics, steep maps.
#include "settings/effects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/instance_parts.h"
#include "scene/scene_parts.h"
#include "settings/steep_maps.h"

namespace glowworm {
namespace {

/// A floor of each of some materials.
Scene floors(const std::vector<Material>& materials) {
  SceneDescription d = floor_description();
  d.geometry = Geometry();
  d.materials = materials;
  for (std::uint32_t i = 0; i < materials.size(); ++i)
    add_quad(d, {0, 0, static_cast<float>(i)}, {1, 0, 0}, {0, 1, 0}, i);
  return Scene(std::move(d));
}

Material material(const char* name, MaterialKind kind, float alpha) {
  Material m;
  m.name = name;
  m.kind = kind;
  m.roughness_u.value = m.roughness_v.value = alpha;
  return m;
}

TEST(EffectNotes, NameTheMaterialsThatMakeCaustics) {
  const Scene scene =
      floors({material("paint", MaterialKind::diffuse, 0), material("glass", MaterialKind::dielectric, 0.02f),
              material("brushed", MaterialKind::conductor, 0.3f), material("mirror", MaterialKind::conductor, 0)});
  EXPECT_THAT(effect_notes(scene, {}), testing::ElementsAre("material \"glass\" (roughness 0.02) makes caustics",
                                                            "material \"mirror\" (roughness 0) makes caustics"));
  RenderSettings indirect;
  indirect.indirect_only = true;
  EXPECT_THAT(effect_notes(scene, indirect),
              testing::Contains("material \"glass\" (roughness 0.02) would make caustics (off: --indirect-only)"));
  RenderSettings path;
  path.integrator = Integrator::path;
  EXPECT_TRUE(effect_notes(scene, path).empty());
}

TEST(EffectNotes, SummariseManyMaterials) {
  const std::vector<Material> many(20, material("glass", MaterialKind::dielectric, 0));
  const std::vector<std::string> notes = effect_notes(floors(many), {});
  ASSERT_EQ(notes.size(), 9u);
  EXPECT_EQ(notes.back(), "more materials like these: 12");
}

/// A floor of four metres along u, and bumps that rise along a share of u and are even on the rest.
SceneDescription bumpy(float share, float slope) {
  SceneDescription d = floor_description();
  d.textures.push_back(image_node([share](Vec2 uv) { return RGB(std::min(uv.x, share)); }));
  d.materials[0].name = "tiles";
  d.materials[0].bump = {4 * slope, 0, Channel::red};
  return d;
}

TEST(SteepMapNotes, NameMaterialsWhoseMapsTurnNormalsFar) {
  EXPECT_THAT(steep_map_notes(Scene(bumpy(0.5f, 1.2f))),
              testing::ElementsAre(testing::AllOf(testing::StartsWith("material \"tiles\" has a steep map"),
                                                  testing::HasSubstr("on 50% of its surface"))));
  EXPECT_THAT(steep_map_notes(Scene(bumpy(0.5f, 0.8f))), testing::IsEmpty()) << "a slope below 1";
  EXPECT_THAT(steep_map_notes(Scene(bumpy(0.02f, 1.2f))), testing::IsEmpty()) << "a small share";
  EXPECT_THAT(steep_map_notes(Scene(floor_description())), testing::IsEmpty());
}

TEST(SteepMapNotes, CountMeshesOfInstances) {
  SceneDescription d = bumpy(0.5f, 1.2f);
  Geometry floor = std::move(d.geometry);
  d.geometry = Geometry();
  floor.emission.assign(floor.triangles.size(), kNone);
  add_places(d, add_shared_mesh(d, std::move(floor)), {Transform(), {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 5}}});
  EXPECT_THAT(steep_map_notes(Scene(std::move(d))), testing::ElementsAre(testing::HasSubstr("on 50% of its surface")));
}

TEST(SteepMapNotes, NameThePartsOfAMix) {
  SceneDescription d = bumpy(0.5f, 1.2f);
  Material mix = material("mix", MaterialKind::mix, 0);
  mix.mix_a = 0;
  mix.mix_b = 2;
  d.materials = {d.materials[0], mix, material("paint", MaterialKind::diffuse, 0)};
  for (std::uint32_t& of : d.geometry.material) of = 1;
  EXPECT_THAT(steep_map_notes(Scene(std::move(d))),
              testing::ElementsAre(testing::StartsWith("material \"tiles\" has a steep map")));
}

}  // namespace
}  // namespace glowworm
