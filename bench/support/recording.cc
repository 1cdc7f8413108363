#include "support/recording.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <utility>

#include "core/memory_budget.h"
#include "density/radius.h"
#include "gather/camera_pass.h"
#include "gather/final_gather.h"
#include "import/import.h"
#include "maps/gather_guiding.h"
#include "maps/photon_guiding.h"
#include "maps/photon_maps.h"
#include "photon/photon_tracer.h"
#include "settings/settings.h"
#include "transport/vertex.h"

namespace glowworm::bench {

namespace {

/// [SF07]'s Sponza, Dabrovic's model, beside the working folder.
constexpr const char* kSponza = "../shared/scenes/sponza-dabrovic/pbrt/sponza-sun.pbrt";

/// What guides a render's photons and gather rays.
struct Guides {
  MemoryBudget budget{default_memory_bytes()};
  PhotonMaps maps{budget};
  std::shared_ptr<const EmissionGuide> emission;
  std::shared_ptr<const PhotonImportance> importance;
  GatherGuide gather;

  void learn(const Stage& stage, const RecordingSettings& wanted) {
    RenderSettings render;
    render.photons = wanted.photons;
    render.width = wanted.width;
    render.height = wanted.height;
    render.gather = wanted.gather;
    const Camera& camera = stage.scene->camera("");
    PhotonGuiding guiding = guide_photons(*stage.tracer, camera, resolve(render, *stage.scene));
    emission = std::make_shared<const EmissionGuide>(std::move(guiding.guide));
    importance = std::make_shared<const PhotonImportance>(std::move(guiding.importance));
    PhotonMapSettings map;
    map.photons = wanted.photons;
    map.guide = emission;
    map.importance = importance;
    map.secondary_gather = true;
    Statistics statistics;
    maps.update(*stage.tracer, map, statistics);
    PassSettings pass;
    pass.width = wanted.width;
    pass.height = wanted.height;
    pass.gather = wanted.gather;
    gather = learn_gather_guide(*stage.tracer, maps, camera, pass, budget, statistics);
  }
};

}  // namespace

Stage::Stage(const std::string& path)
    : scene(std::make_shared<const Scene>(load_scene(path))), tracer(std::make_shared<const Tracer>(*scene)) {}

Recording record(const Stage& stage, const RecordingSettings& settings) {
  Statistics statistics;
  Recording recording;
  Guides guides;
  if (settings.guided) guides.learn(stage, settings);
  PhotonPassSettings photons;
  photons.photons = settings.photons;
  photons.guide = guides.emission.get();
  photons.importance = guides.importance.get();
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
    gather.guide = &guides.gather;
    if (settings.guided) gather.radii = &guides.maps.radii();
    final_gather(*stage.tracer, gather_points, 0, gather_points.size(), gather, radiance, {recording.points},
                 statistics);
  }
  return recording;
}

double mean_k(const Statistics& s) {
  return static_cast<double>(s.count(Counter::shader_operations)) / static_cast<double>(s.count(Counter::query_points));
}

QueryPoints runs_of(const QueryPoints& points, const std::vector<std::uint32_t>& order, std::size_t run,
                    std::size_t step) {
  std::vector<bool> chosen(points.size());
  for (std::size_t place = 0; place < points.size(); ++place)
    chosen[order.empty() ? place : order[place]] = place / run % step == 0;
  QueryPoints some;
  some.bsdfs = points.bsdfs;
  QueryPoints::for_arrays(
      [&](auto& to, const auto& from) {
        for (std::size_t i = 0; i < from.size(); ++i)
          if (chosen[i]) to.push_back(from[i]);
      },
      some, points);
  return some;
}

void look_up(const DensityEngine& engine, const QueryPoints& points, Statistics& statistics) {
  std::vector<RGB> radiance(points.size());
  engine.estimate(points, radiance, statistics);
}

RadiusPolicy fixed_radius_for(const Recording& recording, double k) {
  constexpr std::size_t kSampled = 60'000;
  const QueryPoints sample =
      runs_of(recording.points, {}, 1, std::max<std::size_t>(1, recording.points.size() / kSampled));
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = fixed_radius(recording.photons, static_cast<std::uint32_t>(k));
  for (int round = 0; round < 6; ++round) {
    const auto engine = make_engine("auto");
    Statistics s;
    engine->build(recording.photons, recording.photons.flux, policy, s);
    look_up(*engine, sample, s);
    const double mean = mean_k(s);
    if (mean <= 0 || std::abs(mean / k - 1) < 0.01) break;
    policy.radius *= static_cast<float>(std::sqrt(k / mean));
  }
  return policy;
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
