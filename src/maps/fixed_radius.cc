#include "maps/fixed_radius.h"

#include <cmath>
#include <vector>

#include "core/statistics.h"
#include "maps/photon_noise.h"

namespace glowworm {

namespace {

/// Rounds end when the mean is within this share of the number that is wanted; five or fewer suffice.
constexpr double kDeviation = 0.02;
constexpr int kMostRounds = 8;
/// Squares of pixels that are looked at, at most.
constexpr std::size_t kMostSquares = 1024;

/// The mean number of photons of the maps within reach of query points.
double mean_count(const Tracer& tracer, const PhotonMaps& maps, const View& view, const std::vector<CameraTask>& tasks,
                  const PassSettings& pass, MemoryBudget& budget) {
  PassMemory memory;
  Statistics counted;
  render_pass(tracer, maps, view, tasks, pass, budget, memory, counted);
  const auto queries = static_cast<double>(counted.count(Counter::query_points));
  return queries > 0 ? static_cast<double>(counted.count(Counter::shader_operations)) / queries : 0;
}

}  // namespace

float fixed_radius_for(const Tracer& tracer, PhotonMaps& maps, PhotonMapSettings wanted, const View& view,
                       const PixelBounds& part, const PassSettings& passes, MemoryBudget& budget) {
  wanted.correction = BoundaryCorrection::none;
  wanted.diagnosed = wanted.kept = true;
  wanted.narrow = wanted.patches = wanted.sampled = false;
  PassSettings pass = passes;
  pass.kind = passes.kind == PassKind::photons ? PassKind::count_seen : PassKind::count_gathered;
  pass.places = pass.fine = pass.by_disk = pass.patches = false;
  // Query points of the caustic map do not count.
  pass.indirect = false;
  pass.values = {};
  pass.light_groups = nullptr;
  pass.guide = nullptr;
  std::vector<CameraTask> tasks = squares_of(part, kMostSquares);
  if (tasks.empty()) tasks.push_back({part.x0, part.y0, part.x1, part.y1, 0, 1});
  Statistics not_the_renders;
  for (int round = 0;; ++round) {
    maps.update(tracer, wanted, not_the_renders);
    const float radius = maps.common_radius();
    const double mean = maps.empty() ? 0 : mean_count(tracer, maps, view, tasks, pass, budget);
    const double ratio = mean / wanted.nearest;
    if (!(ratio > 0) || std::abs(ratio - 1) < kDeviation || round == kMostRounds) return radius;
    wanted.radius = radius / static_cast<float>(std::sqrt(ratio));
  }
}

}  // namespace glowworm
