// The scenes of the shared folder, if it exists.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {
namespace {

struct SharedScene {
  const char* file;
  std::size_t triangles;  ///< in the files, each use of a PLY file counted
  std::size_t of_curves;  ///< that stand for spheres and disks: 3,968 for a sphere that is a light, 128 for a disk
};

class SharedScenes : public ::testing::TestWithParam<SharedScene> {};

/// Triangles that the notes say were left out.
std::size_t left_out(const SceneDescription& scene) {
  std::size_t sum = 0;
  for (const std::string& note : scene.notes) {
    if (!note.starts_with("left out: triangles")) continue;
    const std::size_t more = note.find(", and ");
    sum += 1 + (more == std::string::npos ? 0 : std::stoul(note.substr(more + 6)));
  }
  return sum;
}

TEST_P(SharedScenes, Loads) {
  const std::string path = std::string(GLOWWORM_SHARED_DIR) + "/scenes/" + GetParam().file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  const SceneDescription scene = load_scene(path);
  EXPECT_EQ(scene.geometry.triangle_count() + left_out(scene), GetParam().triangles + GetParam().of_curves);
  EXPECT_EQ(scene.cameras.size(), 1u);
  for (const std::string& note : scene.notes) EXPECT_EQ(note.find("magenta"), std::string::npos) << note;
  const Scene checked(scene);
  EXPECT_GT(checked.light_power().total(), 0);
}

INSTANTIATE_TEST_SUITE_P(
    All, SharedScenes,
    ::testing::Values(SharedScene{"cornell-grey-pbrt/cornell-grey-reference.pbrt", 32, 0},
                      SharedScene{"bitterli-cornell-box-pbrt/cornell-box-reference.pbrt", 32, 0},
                      SharedScene{"sponza-dabrovic/pbrt/sponza-sun.pbrt", 66445, 0},
                      SharedScene{"bitterli-veach-ajar-pbrt/veach-ajar-reference.pbrt", 382690, 0},
                      SharedScene{"bitterli-living-room-pbrt/living-room-reference.pbrt", 143163, 0},
                      SharedScene{"bitterli-staircase2-pbrt/staircase2-reference.pbrt", 30927, 5 * 128},
                      SharedScene{"bitterli-veach-bidir-pbrt/veach-bidir-reference.pbrt", 11544, 0},
                      SharedScene{"bitterli-veach-mis-pbrt/veach-mis.pbrt", 52, 3 * 3968}));

}  // namespace
}  // namespace glowworm
