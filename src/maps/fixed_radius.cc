#include "maps/fixed_radius.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/statistics.h"
#include "maps/photon_noise.h"

namespace glowworm {

namespace {

/// Rounds end when the mean is within this share of the number that is wanted; even photons take up to six.
constexpr double kDeviation = 0.02;
constexpr int kMostRounds = 12;
/// The mean grows with this power of the radius where photons are even. The power lies between the other two where they
/// are not: it is small where wider kernels reach no more photons, and large where most query points are far from all.
constexpr double kEvenPower = 2, kLeastPower = 0.25, kMostPower = 8;
/// A round changes the radius by this factor at most: the cost of a count grows with its square.
constexpr double kMostStep = 2;
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
  wanted.diagnosed = wanted.kept = true;
  wanted.narrow = wanted.narrow_caustic = wanted.patches = wanted.sampled = false;
  PassSettings pass = passes;
  pass.kind = passes.kind == PassKind::photons ? PassKind::count_seen : PassKind::count_gathered;
  pass.places = pass.surface_samples = pass.by_disk = pass.patches = false;
  // Query points of the caustic map do not count.
  pass.indirect = false;
  pass.values = {};
  pass.light_groups = nullptr;
  std::vector<CameraTask> tasks = squares_of(part, kMostSquares);
  if (tasks.empty()) tasks.push_back({part.x0, part.y0, part.x1, part.y1, 0, 1});
  Statistics not_the_renders;
  // Other processes share the photons, but not what each round makes of them: where walls cut their kernels.
  const BoundaryCorrection correction = std::exchange(wanted.correction, BoundaryCorrection::none);
  maps.update(tracer, wanted, not_the_renders);
  wanted.correction = correction;
  wanted.shared = nullptr;
  double power = kEvenPower, last_radius = 0, last_ratio = 0, best_error = std::numeric_limits<double>::infinity();
  float best = 0, too_small = 0, too_large = std::numeric_limits<float>::infinity();
  for (int round = 0;; ++round) {
    maps.update(tracer, wanted, not_the_renders);
    const float radius = maps.common_radius();
    const double mean = maps.empty() ? 0 : mean_count(tracer, maps, view, tasks, pass, budget);
    const double ratio = mean / wanted.nearest;
    if (!(ratio > 0)) return radius;
    if (const double error = std::abs(std::log(ratio)); error < best_error) best = radius, best_error = error;
    if (best_error < kDeviation || round == kMostRounds) return best;
    (ratio < 1 ? too_small : too_large) = radius;
    if (round > 0)
      power = std::clamp(std::log(ratio / last_ratio) / std::log(radius / last_radius), kLeastPower, kMostPower);
    last_radius = radius;
    last_ratio = ratio;
    wanted.radius = static_cast<float>(radius * std::clamp(std::pow(ratio, -1 / power), 1 / kMostStep, kMostStep));
    if (!(wanted.radius > too_small && wanted.radius < too_large)) wanted.radius = std::sqrt(too_small * too_large);
  }
}

}  // namespace glowworm
