#include "maps/photon_guiding.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/archive.h"
#include "core/parallel.h"
#include "gather/camera_pass.h"
#include "gather/final_gather.h"
#include "photon/material_lobes.h"
#include "transport/vertex.h"

namespace glowworm {

namespace {

constexpr double kPilotPixels = 4096;
constexpr std::uint32_t kPilotGatherRays = 6;
/// Pilot rounds: the first emits in proportion to power, and each later one is guided by those before it.
constexpr int kRounds = 4;
/// Paths of a round: a share of the wanted photons, within bounds. Learning ends when its paths have stored so many
/// photons each.
constexpr std::uint64_t kPhotonsAPath = 8, kMinPaths = 16384, kMaxPaths = 65536;

ImportanceGrid grid_of(const QueryPoints& queries) {
  std::vector<float> weights;
  for (const RGB& w : queries.weight) weights.push_back(std::max(0.0f, luminance(w)));
  return ImportanceGrid(queries.position, queries.normal, weights);
}

/// Gather points of coarse pictures. Those of each camera have slots of their own in `radiance`.
GatherPoints coarse_points(const Tracer& tracer, std::span<const Camera* const> cameras, const RenderSettings& settings,
                           SlotRadiance& radiance) {
  const double pixels = static_cast<double>(settings.width) * settings.height;
  const double scale = std::min(1.0, std::sqrt(kPilotPixels / pixels));
  CameraPassSettings camera_settings;
  camera_settings.width = std::max(1, static_cast<int>(std::lround(settings.width * scale)));
  camera_settings.height = std::max(1, static_cast<int>(std::lround(settings.height * scale)));
  camera_settings.seed = settings.seed;
  CameraTask task;
  task.x1 = camera_settings.width;
  task.y1 = camera_settings.height;
  // A small picture takes more samples a pixel.
  task.sample_count =
      static_cast<std::uint32_t>(std::clamp(kPilotPixels / (static_cast<double>(task.x1) * task.y1), 1.0, 64.0));
  Statistics statistics;  // of the pilot, which is not part of the render's counts
  GatherPoints all;
  const auto slots = static_cast<std::uint32_t>(CameraTasks(task).slot_count());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    FirstHit first_hit;
    GatherPoints points = camera_pass(tracer, *cameras[i], task, camera_settings, radiance, first_hit, statistics);
    for (std::uint32_t& slot : points.slot) slot += static_cast<std::uint32_t>(i) * slots;
    all.append(points);
  }
  radiance.resize(cameras.size() * slots);
  return all;
}

/// Evenly chosen points of the grid.
GatherPoints coarse_points(const Tracer& tracer, const PointGrid& grid, SlotRadiance& radiance) {
  std::vector<std::size_t> cells;
  for (std::size_t cell = 0; cell < grid.normal.size(); ++cell)
    if (grid.has(cell)) cells.push_back(cell);
  const auto most = static_cast<std::size_t>(kPilotPixels);
  PointGrid pilot;
  for (std::size_t i = 0; i < std::min(cells.size(), most); ++i) {
    const std::size_t cell = cells[cells.size() <= most ? i : i * cells.size() / most];
    pilot.append(grid, cell);
  }
  pilot.width = static_cast<int>(pilot.position.size());
  pilot.height = 1;
  CameraTask task;
  task.x1 = pilot.width;
  task.y1 = 1;
  if (pilot.width > 0)
    task.sample_count = static_cast<std::uint32_t>(std::clamp(kPilotPixels / pilot.width, 1.0, 64.0));
  GatherPoints points;
  Statistics statistics;
  FirstHit first_hit;
  point_pass(tracer, pilot, task, radiance, first_hit, points, statistics);
  return points;
}

/// PhotonImportance::box
Box3 box_of(const Scene& scene, const View& view, const QueryPoints& seen) {
  Box3 out = scene.bounds();
  for (const Camera* const camera : view.cameras()) out.grow(camera->to_world.point({0, 0, 0}));
  for (const Vec3 position : seen.position) out.grow(position);
  return out;
}

PhotonImportance find_importance(const Tracer& tracer, const View& view, const RenderSettings& settings) {
  SlotRadiance radiance;
  const GatherPoints points = view.points ? coarse_points(tracer, *view.points, radiance)
                                          : coarse_points(tracer, view.cameras(), settings, radiance);
  Statistics statistics;
  PhotonImportance importance;
  const QueryPoints seen = gather_points_as_queries(points);
  importance.seen = grid_of(seen);
  importance.box = box_of(tracer.scene(), view, seen);
  if (settings.integrator == Integrator::photons) {
    importance.gathered = importance.seen;
    return importance;
  }
  FinalGatherSettings gather;
  gather.rays = kPilotGatherRays;
  gather.seed = settings.seed;
  gather.photons_alone = true;
  QueryPoints queries;
  final_gather(tracer, points, 0, points.size(), gather, radiance, {queries}, statistics);
  importance.gathered = grid_of(queries);
  return importance;
}

std::size_t count_hits(std::span<const PilotPath> paths) {
  return static_cast<std::size_t>(
      std::count_if(paths.begin(), paths.end(), [](const PilotPath& path) { return path.score > 0; }));
}

/// Learns from the paths of all rounds so far. @param guides of the rounds; @param counts their numbers of paths
EmissionGuide learn(std::vector<PilotPath>& paths, const std::vector<EmissionGuide>& guides,
                    const std::vector<std::size_t>& counts, float floor) {
  // Balance heuristic over the rounds: each path has the combined density of all rounds.
  parallel_for_each(paths.size(), 4096, [&](std::size_t i) {
    double density = 0;
    for (std::size_t r = 0; r < guides.size(); ++r)
      density +=
          guides[r].density(paths[i].numbers) * static_cast<double>(counts[r]) / static_cast<double>(paths.size());
    paths[i].density = static_cast<float>(density);
  });
  return EmissionGuide::learn(paths, floor);
}

PhotonGuiding learn_guiding(const Tracer& tracer, const View& view, const RenderSettings& settings) {
  PhotonGuiding out;
  out.importance = find_importance(tracer, view, settings);
  if (out.importance.gathered.empty() && out.importance.seen.empty()) return out;
  if (!may_have_lobes(tracer.scene(), kBroad)) return out;
  PhotonPassSettings pilot;
  pilot.seed = settings.seed;
  pilot.pass = kPilotStream;  // a pass number that photons never use
  pilot.importance = &out.importance;
  out.guide = learn_emission(tracer, pilot, {.count = guiding_paths(settings)});
  return out;
}

}  // namespace

EmissionGuide learn_emission(const Tracer& tracer, PhotonPassSettings pilot, const EmissionLearning& learning) {
  std::vector<PilotPath> paths;
  std::vector<EmissionGuide> guides;
  std::vector<std::size_t> counts;
  double share = 0;  // share of contributing paths in the last round
  // Paths of a closed white room would bounce on and on.
  std::uint64_t photons_left =
      kPhotonsAPath * learning.count * (learning.most_in_first + static_cast<std::size_t>(learning.most_rounds));
  // More rounds follow while less than a fifth of a round's paths contribute.
  for (int round = 0; round < kRounds || (round < learning.most_rounds && share < 0.2); ++round) {
    if (photons_left == 0) break;
    const EmissionGuide guide = paths.empty() ? EmissionGuide() : learn(paths, guides, counts, learning.floor);
    pilot.guide = &guide;
    const std::size_t before = paths.size();
    do {
      const std::vector<PilotPath> more = trace_pilot(tracer, pilot, paths.size(), learning.count, photons_left);
      paths.insert(paths.end(), more.begin(), more.end());
      // If too few of the first paths contribute, more are emitted.
    } while (round == 0 && count_hits(paths) < 128 && paths.size() < learning.most_in_first * learning.count &&
             photons_left > 0);
    guides.push_back(guide);
    counts.push_back(paths.size() - before);
    share = static_cast<double>(count_hits(std::span(paths).subspan(before))) / static_cast<double>(counts.back());
    // Where most paths contribute, a guide cannot gain much.
    if (round == 0 && (share == 0 || share > 0.4)) return {};
  }
  EmissionGuide guide = learn(paths, guides, counts, learning.floor);
  // A smaller gain does not make up for the uneven flux of photons.
  return guide.gain() >= 1.5 ? guide : EmissionGuide();
}

std::size_t guiding_paths(const RenderSettings& settings) {
  return static_cast<std::size_t>(std::clamp(settings.photons / kPhotonsAPath, kMinPaths, kMaxPaths));
}

PhotonGuiding guide_photons(const Tracer& tracer, const View& view, const RenderSettings& settings,
                            SharedWork* shared) {
  if (!shared) return learn_guiding(tracer, view, settings);
  const auto make = [&](std::size_t) {
    const PhotonGuiding made = learn_guiding(tracer, view, settings);
    return archived(made.guide, made.importance.gathered, made.importance.seen, made.importance.box.min,
                    made.importance.box.max);
  };
  PhotonGuiding out;
  const auto take = [&](std::size_t, std::span<const std::byte> bytes) {
    unarchive(bytes, out.guide, out.importance.gathered, out.importance.seen, out.importance.box.min,
              out.importance.box.max);
  };
  shared->divide("photon-guide", 1, make, take);
  return out;
}

}  // namespace glowworm
