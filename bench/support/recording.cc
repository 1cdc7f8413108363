#include "support/recording.h"

#include <chrono>
#include <filesystem>

#include "gather/camera_pass.h"
#include "gather/final_gather.h"
#include "import/import.h"
#include "photon/photon_tracer.h"

namespace glowworm::bench {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

}  // namespace

Stage::Stage(const std::string& path)
    : scene(std::make_unique<const Scene>(load_scene(path))), tracer(std::make_unique<const Tracer>(*scene)) {}

Recording record(const Stage& stage, const RecordingSettings& settings) {
  Statistics statistics;
  Recording recording;
  PhotonPassSettings photons;
  photons.photons = settings.photons;
  Clock::time_point start = Clock::now();
  recording.photons = trace_photons(*stage.tracer, photons, statistics).global;
  recording.photon_seconds = seconds_since(start);
  CameraPassSettings camera;
  camera.width = settings.width;
  camera.height = settings.height;
  CameraTask task;
  task.x1 = settings.width;
  task.y1 = settings.height;
  SlotRadiance radiance;
  FirstHit first_hit;
  start = Clock::now();
  const GatherPoints gather_points =
      camera_pass(*stage.tracer, stage.scene->camera(""), task, camera, radiance, first_hit, statistics);
  if (settings.gather == 0) {
    recording.points = gather_points_as_queries(gather_points);
  } else {
    FinalGatherSettings gather;
    gather.rays = settings.gather;
    final_gather(*stage.tracer, gather_points, 0, gather_points.size(), gather, radiance, recording.points, statistics);
  }
  recording.ray_seconds = seconds_since(start);
  return recording;
}

std::string sponza_path() {
  const std::string path = "../shared/scenes/sponza-dabrovic/pbrt/sponza-sun.pbrt";
  return std::filesystem::exists(path) ? path : "";
}

std::vector<std::string> table_scenes() {
  std::vector<std::string> scenes = {"builtin:cornell", "builtin:atrium"};
  if (const std::string sponza = sponza_path(); !sponza.empty()) scenes.push_back(sponza);
  return scenes;
}

std::string short_name(const std::string& path) {
  constexpr const char* kBuiltin = "builtin:";
  if (path.starts_with(kBuiltin)) return path.substr(std::string(kBuiltin).size());
  return path == sponza_path() ? "sponza" : std::filesystem::path(path).stem().string();
}

}  // namespace glowworm::bench
