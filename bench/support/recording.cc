#include "support/recording.h"

#include <filesystem>
#include <string_view>

#include "gather/camera_pass.h"
#include "gather/final_gather.h"
#include "import/import.h"
#include "photon/photon_tracer.h"

namespace glowworm::bench {

namespace {

/// [SF07]'s Sponza, Dabrovic's model, beside the working folder.
constexpr const char* kSponza = "../shared/scenes/sponza-dabrovic/pbrt/sponza-sun.pbrt";

}  // namespace

Stage::Stage(const std::string& path)
    : scene(std::make_shared<const Scene>(load_scene(path))), tracer(std::make_shared<const Tracer>(*scene)) {}

Recording record(const Stage& stage, const RecordingSettings& settings) {
  Statistics statistics;
  Recording recording;
  PhotonPassSettings photons;
  photons.photons = settings.photons;
  recording.photons = trace_photons(*stage.tracer, photons, statistics).global;
  CameraPassSettings camera;
  camera.width = settings.width;
  camera.height = settings.height;
  CameraTask task;
  task.x1 = settings.width;
  task.y1 = settings.height;
  SlotRadiance radiance;
  FirstHit first_hit;
  const GatherPoints gather_points =
      camera_pass(*stage.tracer, stage.scene->camera(""), task, camera, radiance, first_hit, statistics);
  if (settings.gather == 0) {
    recording.points = gather_points_as_queries(gather_points);
  } else {
    FinalGatherSettings gather;
    gather.rays = settings.gather;
    final_gather(*stage.tracer, gather_points, 0, gather_points.size(), gather, radiance, {recording.points},
                 statistics);
  }
  return recording;
}

std::vector<std::string> table_scenes() {
  std::vector<std::string> scenes = {"builtin:cornell", "builtin:atrium"};
  if (std::filesystem::exists(kSponza)) scenes.emplace_back(kSponza);
  return scenes;
}

std::string short_name(const std::string& path) {
  constexpr std::string_view kBuiltin = "builtin:";
  if (path.starts_with(kBuiltin)) return path.substr(kBuiltin.size());
  return path == kSponza ? "sponza" : std::filesystem::path(path).stem().string();
}

}  // namespace glowworm::bench
