#include "import/volume_text.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/input_file.h"
#include "core/text.h"
#include "import/voxel_grid.h"

namespace glowworm {

namespace {

struct VolumeText {
  std::string file;
  float scale = 1, albedo = 0.5f;
};

VolumeText read_volume(const std::string& text) {
  VolumeText out;
  std::string_view rest = text;
  for (std::size_t comma = rest.rfind(','); comma != std::string_view::npos; comma = rest.rfind(',')) {
    const std::string_view part = rest.substr(comma + 1);
    const std::size_t equals = part.find('=');
    const bool is_scale = part.starts_with("scale=");
    if (!is_scale && !part.starts_with("albedo=")) break;
    const std::vector<float> number = numbers_of<float>(part.substr(equals + 1));
    if (number.size() != 1 || !(number[0] >= 0) || number[0] > (is_scale ? 1e6f : 1))
      throw Error(fmt::format("--volume '{}' has the {} '{}'", text, part.substr(0, equals), part.substr(equals + 1)),
                  "Give a scale from 0 to a million, and an albedo from 0 to 1.");
    (is_scale ? out.scale : out.albedo) = number[0];
    rest = rest.substr(0, comma);
  }
  out.file = rest;
  const std::string ending = lower_ending(out.file);
  if (ending != ".vdb" && ending != ".nvdb")
    throw Error(fmt::format("--volume '{}' names no .vdb or .nvdb file", text),
                "Write FILE[,scale=S][,albedo=A], for example smoke.vdb,scale=2,albedo=0.9.");
  return out;
}

}  // namespace

void check_volume_text(const std::string& text) { read_volume(text); }

void add_volume(const std::string& text, SceneDescription& scene, MemoryBudget& budget) {
  const VolumeText asked = read_volume(text);
  check_input_file(asked.file);
  VoxelGrid read = read_voxel_grid(asked.file, "density", budget);
  TransformDouble placed = read.to_world;
  if (scene.z_up)
    for (Vec3d* const axis : {&placed.x, &placed.y, &placed.z, &placed.translation}) *axis = y_up_from_z_up(*axis);
  placed.translation = placed.translation - Vec3d(scene.origin);
  if (!(placed.determinant() != 0)) throw Error({asked.file}, "the transform of its grid cannot be inverted");
  Medium smoke;
  smoke.name = std::filesystem::path(asked.file).filename().string();
  smoke.sigma_s = RGB(asked.scale * asked.albedo);
  smoke.sigma_a = RGB(asked.scale * (1 - asked.albedo));
  place_medium(read, placed, smoke);
  MediumGridValues grid;
  grid.size = read.size;
  grid.density = std::move(read.values);
  try {
    smoke.grid = std::make_shared<const MediumGrid>(std::move(grid));
  } catch (const Error& error) {
    throw Error({asked.file}, error.what());
  }
  if (has_voxel_grid(asked.file, "temperature", budget))
    scene.notes.push_back(fmt::format("temperatures of '{}' do not glow: a pbrt file has media that do", asked.file));
  if (scene.ambient_medium != kNone)
    scene.notes.push_back(
        fmt::format("--volume replaces the medium \"{}\" around the scene", scene.media[scene.ambient_medium].name));
  scene.ambient_medium = static_cast<std::uint32_t>(scene.media.size());
  scene.media.push_back(std::move(smoke));
}

}  // namespace glowworm
