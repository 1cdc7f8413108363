// Runs the seeds of the fuzz targets once each, so that the targets keep working between fuzzing runs.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "core/log.h"
#include "fuzz/parse_once.h"
#include "image/image_file.h"

namespace glowworm {
namespace {

std::size_t for_each_seed(const std::string& folder, const std::function<void(std::string_view)>& run) {
  const std::string path = std::string(GLOWWORM_SOURCE_DIR) + "/tests/fuzz/corpus/" + folder;
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    run(bytes);
    // What a cut or a flipped bit makes of it must be taken as well.
    run(std::string_view(bytes).substr(0, bytes.size() / 2));
    for (std::size_t i = 0; i < bytes.size(); i += 97) {
      std::string flipped = bytes;
      flipped[i] = static_cast<char>(flipped[i] ^ (1 << (i % 8)));
      run(flipped);
    }
    ++count;
  }
  return count;
}

TEST(FuzzSeeds, Scenes) { EXPECT_GT(for_each_seed("pbrt", fuzz::parse_scene), 5u); }

TEST(FuzzSeeds, MeshesAndSpectra) {
  EXPECT_GT(for_each_seed("ply",
                          [](std::string_view bytes) {
                            fuzz::parse_mesh(bytes);
                            fuzz::parse_spectrum(bytes);
                          }),
            3u);
}

TEST(FuzzSeeds, Textures) {
  set_log_level(LogLevel::quiet);
  for (const char* format : {"png", "jpeg", "exr", "hdr", "tiff", "tga", "bmp", "webp", "gif"}) {
    const std::string folder = std::string("texture/") + format;
    EXPECT_GT(for_each_seed(folder, fuzz::parse_texture), 1u) << format;
  }
}

/// OpenImageIO's own function for them reads beyond the end of damaged ones.
TEST(FuzzSeeds, IccProfilesAreLeftOut) {
  for (const char* name : {"jpeg/icc.jpg", "png/icc.png", "tiff/icc.tif"}) {
    const ImageFileHeader header =
        read_image_header(std::string(GLOWWORM_SOURCE_DIR) + "/tests/fuzz/corpus/texture/" + name);
    EXPECT_EQ(header.width, 4) << name;
    for (const auto& [key, value] : header.metadata)
      EXPECT_EQ(key.find("ICC"), std::string::npos) << name << ' ' << key;
  }
}

TEST(FuzzSeeds, GltfFiles) { EXPECT_GT(for_each_seed("gltf", fuzz::parse_gltf), 10u); }

TEST(FuzzSeeds, ObjFilesAndTheirMaterials) { EXPECT_GT(for_each_seed("obj", fuzz::parse_obj_and_mtl), 2u); }

TEST(FuzzSeeds, StlFiles) { EXPECT_GT(for_each_seed("stl", fuzz::parse_stl_mesh), 1u); }

TEST(FuzzSeeds, ScenesOfRadiance) { EXPECT_GT(for_each_seed("rad", fuzz::parse_rad_scene), 2u); }

TEST(FuzzSeeds, DataOfWindows) { EXPECT_GT(for_each_seed("window", fuzz::parse_window), 1u); }

TEST(FuzzSeeds, ScenesHandedOverByAssimp) { EXPECT_GT(for_each_seed("assimp", fuzz::parse_hand_over), 2u); }

}  // namespace
}  // namespace glowworm
