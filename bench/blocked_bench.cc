// The blocked density engine on a scene's own photons and query points, beside the other engines and nanoflann's radius
// search on the same points in the same run. Writes tables to standard output.
//
//   blocked_bench [--scene builtin:atrium] [--size 320] [--gather 100] [--photons 2000000] [--k 50] [--threads 0]
//                 [--repeats 5] [--depths 1] [--others 1]
//   --depths  also the curve of reordering and query time over the depth of the order (engine forward)
//   --others  also the other engines and nanoflann
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "density/engine.h"
#include "density/forward.h"
#include "density/radius.h"
#include "density/reorder.h"
#include "kernels/simd.h"
#include "support/nanoflann_tree.h"
#include "support/recording.h"

namespace glowworm {
namespace {

using Options = std::map<std::string, std::string>;

using bench::Recording;

struct Measured {
  double wall, processor;  ///< seconds
};

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Medians of several runs.
Measured measure(int repeats, const std::function<void()>& work) {
  std::vector<double> wall, processor;
  for (int i = 0; i < repeats; ++i) {
    const double start = seconds_now();
    const std::clock_t clock = std::clock();
    work();
    wall.push_back(seconds_now() - start);
    processor.push_back(static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC);
  }
  const auto median = [](std::vector<double>& values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  return {median(wall), median(processor)};
}

void run_engine(const std::string& name, const Recording& input, const RadiusPolicy& policy, int repeats) {
  const auto engine = make_engine(name);
  Statistics building, once;
  engine->build(input.photons, policy, building);
  std::vector<RGB> radiance(input.points.size());
  engine->estimate(input.points, radiance, once);
  Statistics s;
  const Measured m = measure(repeats, [&] { engine->estimate(input.points, radiance, s); });
  const auto n = static_cast<double>(input.points.size()),
             operations = static_cast<double>(once.count(Counter::shader_operations));
  const double reorder = s.seconds(Phase::reorder), density = s.seconds(Phase::density);
  fmt::print("| {} | {:.3f} | {:.3f} | {:.3f} | {:.0f} | {:.1f}% | {:.1f} | {:.1f}% | {:.3f} | {:.3f} |\n", name,
             building.seconds(Phase::build_photon_map), m.wall, m.processor, 1e9 * m.processor / n,
             100 * reorder / (reorder + density), operations / n,
             100 * operations / static_cast<double>(once.count(Counter::pairs_tested)),
             1e-9 * operations / m.wall / thread_count(), 1e-9 * operations / m.processor);
  std::fflush(stdout);
}

/// Time to reorder, and to look up in that order with the forward engine, over the depth of the order.
void run_depths(const Recording& input, const RadiusPolicy& policy) {
  fmt::print(
      "\n| method | depth or threshold | reorder s | query s | sum s | processor s | "
      "|\n|---|---|---|---|---|---|---|\n");
  const int chosen = automatic_depth(input.points.size(), input.photons.size());
  const auto run = [&](const char* method, const ReorderSettings& settings, int shown, bool automatic) {
    ForwardOptions options;
    options.reorder = settings;
    const auto engine = make_forward_engine(options);
    Statistics s;
    engine->build(input.photons, policy, s);
    std::vector<RGB> radiance(input.points.size());
    const Measured m = measure(1, [&] { engine->estimate(input.points, radiance, s); });
    const double reorder = s.seconds(Phase::reorder), query = s.seconds(Phase::density);
    fmt::print("| {} | {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {} |\n", method, shown, reorder, query, reorder + query,
               m.processor, automatic ? "auto" : "");
    std::fflush(stdout);
  };
  run("none", {ReorderMethod::none, 0, 0}, 0, false);
  for (int depth = 3; depth <= 12; ++depth) run("radix", {ReorderMethod::radix, 0, depth}, depth, depth == chosen);
  for (const std::uint32_t threshold : {4u, 16u, 64u, 256u})
    run("octree", {ReorderMethod::octree, threshold, kAutomaticDepth}, static_cast<int>(threshold), false);
}

/// nanoflann's radius search, which finds pairs but evaluates nothing and knows no normals, on runs of the sorted query
/// points; on one thread. Neither the tree nor the sorting counts.
void run_nanoflann(const Recording& input, float radius, int repeats) {
  const bench::NanoflannPoints photons{input.photons.position};
  bench::NanoflannTree tree(3, photons, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  tree.buildIndex();
  ReorderSettings settings;
  settings.depth = 21;
  const auto order =
      hilbert_order(input.points.position, bounds_of(input.points.position), input.photons.size(), settings);
  std::vector<std::pair<std::uint32_t, float>> found;
  nanoflann::SearchParams unsorted;
  unsorted.sorted = false;
  std::uint64_t pairs = 0, queries = 0;
  const Measured m = measure(repeats, [&] {
    pairs = queries = 0;
    constexpr std::size_t kRun = 4000, kStep = 80000;
    for (std::size_t first = 0; first < order.size(); first += kStep)
      for (std::size_t i = first; i < std::min(first + kRun, order.size()); ++i, ++queries)
        pairs += tree.radiusSearch(&input.points.position[order[i]].x, radius * radius, found, unsorted);
  });
  fmt::print("| nanoflann radius search | | | | {:.0f} | | {:.1f} | | | {:.3f} |\n",
             1e9 * m.processor / static_cast<double>(queries),
             static_cast<double>(pairs) / static_cast<double>(queries),
             1e-9 * static_cast<double>(pairs) / m.processor);
}

}  // namespace
}  // namespace glowworm

int main(int argc, char** argv) {
  using namespace glowworm;
  Options options = {{"--scene", "builtin:atrium"},
                     {"--size", "320"},
                     {"--gather", "100"},
                     {"--photons", "2000000"},
                     {"--k", "50"},
                     {"--threads", "0"},
                     {"--repeats", "5"},
                     {"--depths", "1"},
                     {"--others", "1"}};
  for (int i = 1; i + 1 < argc; i += 2) options[argv[i]] = argv[i + 1];
  const int repeats = std::stoi(options["--repeats"]);
  bench::RecordingSettings recorded;
  recorded.photons = std::stoul(options["--photons"]);
  recorded.width = recorded.height = std::stoi(options["--size"]);
  recorded.gather = static_cast<std::uint32_t>(std::stoul(options["--gather"]));
  const Recording input = bench::record(bench::Stage(options["--scene"]), recorded);
  set_thread_count(std::stoi(options["--threads"]));
  RadiusPolicy per_photon, fixed, nearest;
  nearest.kind = RadiusKind::nearest;
  nearest.k = static_cast<std::uint32_t>(std::stoul(options["--k"]));
  per_photon.radii = per_photon_radii(input.photons, nearest.k);
  fixed.kind = RadiusKind::fixed;
  fixed.radius = fixed_radius(input.photons, nearest.k);
  nearest.max_radius = 2 * *std::max_element(per_photon.radii.begin(), per_photon.radii.end());
  fmt::print("{}: {} photons, {} query points ({} not Lambertian), {}, {} threads\n\n", options["--scene"],
             input.photons.size(), input.points.size(), input.points.bsdfs.size(), simd_name(), thread_count());
  fmt::print(
      "| engine | build s | wall s | processor s | ns a query | reorder | k | pairs used | 1e9/s a core (wall) | 1e9/s "
      "a "
      "core (processor) |\n|---|---|---|---|---|---|---|---|---|---|\n");
  run_engine("blocked", input, per_photon, repeats);
  run_engine("blocked", input, fixed, repeats);
  if (options["--others"] == "1") {
    run_nanoflann(input, fixed.radius, repeats);
    run_engine("forward", input, per_photon, 1);
    run_engine("knn", input, nearest, 1);
  }
  if (options["--depths"] == "1") run_depths(input, per_photon);
}
