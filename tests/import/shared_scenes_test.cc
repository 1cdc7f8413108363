// Real assets, if their folder exists: triangle counts as stated by their sources.
#include "test_files.h"

namespace glowworm {
namespace {

struct Asset {
  const char* file;
  std::size_t triangles;
};

class SharedScenes : public testing::TestWithParam<Asset> {};

TEST_P(SharedScenes, HaveTheTrianglesThatTheirSourceStates) {
  const std::string file = std::string(GLOWWORM_SHARED_DIR) + "/scenes/" + GetParam().file;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  const auto d = load_scene(file);
  EXPECT_EQ(d.geometry.triangle_count(), GetParam().triangles);
  EXPECT_THAT(d.notes, testing::Not(HasNote("magenta")));
}

INSTANTIATE_TEST_SUITE_P(Obj, SharedScenes,
                         testing::Values(Asset{"cornellbox-mcguire/CornellBox-Original.obj", 36},
                                         Asset{"cornellbox-mcguire/CornellBox-Mirror.obj", 36},
                                         Asset{"cornellbox-mcguire/CornellBox-Empty-CO.obj", 12},
                                         Asset{"cornellbox-mcguire/CornellBox-Glossy.obj", 1112},
                                         Asset{"cornellbox-mcguire/CornellBox-Sphere.obj", 2188},
                                         Asset{"cornellbox-mcguire/CornellBox-Water.obj", 7088},
                                         Asset{"sponza-dabrovic/sponza.obj", 66445}));
INSTANTIATE_TEST_SUITE_P(Gltf, SharedScenes,
                         testing::Values(Asset{"gltf-small/renderling/DamagedHelmet.glb", 15452},
                                         Asset{"gltf-small/renderling/EmissiveStrengthTest.glb", 90},
                                         Asset{"gltf-small/cornell-box-rayferric/cornell-box.gltf", 1008},
                                         Asset{"gltf-small/renderling/light_tiling_test.glb", 2330},
                                         Asset{"gltf-small/assimp/ClearCoat-glTF/ClearCoatTest.gltf", 37116}));

}  // namespace
}  // namespace glowworm
