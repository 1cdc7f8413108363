// Figures of the density engines: how many shader operations a second, beside nanoflann's radius search on the same
// points in the same run; and which engine `auto` takes for maps and pictures of many sizes, beside what each would
// have taken. Writes to bench/results/.
//
// usage: tables_engines [rates] [limits] [auto] [SCENE]...     (default: all, on the scenes of table_scenes(); limits:
// the atrium)
//   rates   shader operations a second
//   limits  what of the phase is not sums, and what moving the points' bytes takes at least
//   auto    the engine that `auto` takes
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "core/large_array.h"
#include "core/parallel.h"
#include "density/engine_choice.h"
#include "density/radius.h"
#include "density/reorder.h"
#include "kernels/simd.h"
#include "support/arguments.h"
#include "support/calibration.h"
#include "support/nanoflann_tree.h"
#include "support/recording.h"
#include "support/run_tables.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

constexpr double kRateK = 50;
constexpr int kRuns = 5;

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Pairs a second that nanoflann's radius search finds (in millions), on one thread, in every 20th run of 4096 points
/// along the Hilbert curve. It evaluates nothing and compares no normals; photons stand in its array along a Morton
/// curve, as near each other as those of the engine.
double nanoflann_rate(const Recording& recording, float radius) {
  ReorderSettings settings;
  settings.depth = 21;
  const auto photon_order =
      hilbert_order(recording.photons.position, bounds_of(recording.photons.position), 0, settings);
  std::vector<Vec3> sorted;
  for (const std::uint32_t i : photon_order) sorted.push_back(recording.photons.position[i]);
  const NanoflannPoints view{sorted};
  NanoflannTree tree(3, view, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  tree.buildIndex();
  const auto order = hilbert_order(recording.points.position, bounds_of(recording.points.position), 0, settings);
  nanoflann::SearchParams unsorted;
  unsorted.sorted = false;
  std::vector<std::pair<std::uint32_t, float>> found;
  constexpr std::size_t kRun = 4096, kStep = 20 * kRun;
  std::vector<double> rates;
  for (int run = 0; run < kRuns; ++run) {
    std::uint64_t pairs = 0;
    const double start = processor_seconds();
    for (std::size_t first = 0; first < order.size(); first += kStep)
      for (std::size_t i = first; i < std::min(first + kRun, order.size()); ++i)
        pairs += tree.radiusSearch(&recording.points.position[order[i]].x, radius * radius, found, unsorted);
    rates.push_back(1e-6 * static_cast<double>(pairs) / (processor_seconds() - start));
  }
  return spread_of(rates).median;
}

struct Rates {
  Spread wall, processor;  ///< millions of shader operations a second a core
  double k, used, share;   ///< mean pairs a point; shader operations over pairs tested; reordering over both phases
};

Rates engine_rates(const Recording& recording, const RadiusPolicy& policy, const std::string& name, int runs) {
  const auto engine = make_engine(name);
  Statistics building;
  engine->build(recording.photons, policy, building);
  std::vector<RGB> radiance(recording.points.size());
  // Memory that was never used before is cleared by the system first; a render does so once.
  Statistics first;
  engine->estimate(recording.points, radiance, first);
  const double operations = 1e-6 * static_cast<double>(first.count(Counter::shader_operations));
  std::vector<double> wall, processor, share;
  for (int i = 0; i < runs; ++i) {
    Statistics s;
    const double start = processor_seconds();
    wall.push_back(operations / measure_seconds(1, [&] { engine->estimate(recording.points, radiance, s); }).median /
                   thread_count());
    processor.push_back(operations / (processor_seconds() - start));
    share.push_back(s.seconds(Phase::reorder) / (s.seconds(Phase::reorder) + s.seconds(Phase::density)));
  }
  const auto pairs = static_cast<double>(first.count(Counter::pairs_tested));
  return {spread_of(wall), spread_of(processor), 1e6 * operations / static_cast<double>(recording.points.size()),
          1e6 * operations / pairs, spread_of(share).median};
}

void table_of_rates(const std::vector<std::string>& scenes) {
  Table table("density-rates", "Density estimation: 320 x 320 pixels, 100 samples, 2 M photons",
              {"scene", "search", "radii", "k", "pairs used, %", "reordering, % of the phase",
               "millions a second a core, wall", "the same, processor time", "over nanoflann"});
  for (const std::string& path : scenes) {
    const std::string scene = short_name(path);
    const Recording recording = record(Stage(path), {2'000'000, 320, 320, 100});
    const RadiusPolicy own = own_radii_for(recording, kRateK), fixed = fixed_radius_for(recording, kRateK);
    const double rival = nanoflann_rate(recording, fixed.radius);
    table.add({scene, "nanoflann, pairs found", "fixed", {}, {}, {}, {}, Number{rival}, Number{1.0}});
    const auto row = [&](const std::string& engine, const RadiusPolicy& policy, int runs) {
      const Rates r = engine_rates(recording, policy, engine, runs);
      table.add({scene, engine, policy.kind == RadiusKind::fixed ? "fixed" : "each its own", Number{r.k},
                 Number{100 * r.used}, Number{100 * r.share}, r.wall, r.processor, Number{r.processor.median / rival}});
    };
    set_thread_count(1);
    row("blocked", own, kRuns);
    row("blocked", fixed, kRuns);
    set_thread_count(0);
    row("blocked", own, kRuns);
    row("blocked", fixed, kRuns);
    for (const std::string& simd : simd_names()) {
      if (simd == "ssse3" || simd == simd_names().front()) continue;
      set_simd(simd);
      row("blocked", own, 1);
    }
    set_simd("auto");
  }
  table.note(
      fmt::format("Radii times one factor, with which a query point sees {} photons in the mean. The whole phase "
                  "counts: ordering the query points, looking up, adding the answers to the radiances.",
                  kRateK));
  table.write();
}

/// Nanoseconds of processor time a query point, the least of several runs.
double least_nanoseconds(std::size_t points, const std::function<void()>& work) {
  double least = 0;
  for (int i = 0; i < kRuns; ++i) {
    const double start = processor_seconds();
    work();
    const double seconds = processor_seconds() - start;
    least = i == 0 ? seconds : std::min(least, seconds);
  }
  return 1e9 * least / static_cast<double>(points);
}

/// What of a point goes through memory when it is moved: read once from the arrays, written once, and read again.
struct MovedRow {
  Vec3 position, normal;
  std::uint32_t bsdf, key;
};

double copy_nanoseconds(const QueryPoints& points) {
  LargeArray<MovedRow> rows(points.size());
  volatile std::uint32_t sink = 0;
  return least_nanoseconds(points.size(), [&] {
    for (std::size_t i = 0; i < points.size(); ++i)
      rows[i] = {points.position[i], points.normal[i], points.bsdf[i], static_cast<std::uint32_t>(i)};
    std::uint32_t sum = 0;
    for (const MovedRow& row : rows) sum += row.key;
    sink = sink + sum;
  });
}

void table_of_limits(const std::vector<std::string>& scenes) {
  Table table("density-limits",
              "Density estimation: what a query point takes, 320 x 320 pixels, 100 samples, 2 M photons",
              {"scene", "what", "k", "ns a query point", "of them reordering, ns"});
  set_thread_count(1);
  for (const std::string& path : scenes) {
    const std::string scene = short_name(path);
    set_thread_count(0);
    const Recording recording = record(Stage(path), {2'000'000, 320, 320, 100});
    const RadiusPolicy own = own_radii_for(recording, kRateK), fixed = fixed_radius_for(recording, kRateK);
    set_thread_count(1);
    RadiusPolicy none = own;
    for (float& radius : none.radii) radius *= 1e-4f;
    std::vector<RGB> radiance(recording.points.size());
    for (const RadiusPolicy* policy : {&own, static_cast<const RadiusPolicy*>(&none)}) {
      const auto engine = make_engine("blocked");
      Statistics s;
      engine->build(recording.photons, *policy, s);
      engine->estimate(recording.points, radiance, s);
      Statistics timed;
      const double k = static_cast<double>(s.count(Counter::shader_operations)) / static_cast<double>(radiance.size());
      const double all =
          least_nanoseconds(radiance.size(), [&] { engine->estimate(recording.points, radiance, timed); });
      const double reorder = 1e9 * timed.seconds(Phase::reorder) / kRuns / static_cast<double>(radiance.size());
      table.add({scene, policy == &own ? "blocked" : "blocked, radii of a ten-thousandth: all but the sums", Number{k},
                 Number{all}, Number{reorder}});
    }
    table.add({scene,
               "moving the points' rows once in the order they have, and reading them again",
               {},
               Number{copy_nanoseconds(recording.points)},
               {}});
    const double rival = nanoflann_rate(recording, fixed.radius);
    table.add({scene,
               "a point at 20 times nanoflann's pairs a second",
               Number{kRateK},
               Number{1e3 * kRateK / (20 * rival)},
               {}});
  }
  set_thread_count(0);
  table.note("Processor time of one thread, the least of several runs; reordering the mean of them.");
  table.write();
}

/// Seconds that building the map and looking all points up takes.
double task_seconds(const std::string& name, const PhotonBatch& photons, const RadiusPolicy& policy,
                    const QueryPoints& points) {
  std::vector<RGB> radiance(points.size());
  return measure_seconds(1,
                         [&] {
                           const auto engine = make_engine(name);
                           Statistics s;
                           engine->build(photons, policy, s);
                           engine->estimate(points, radiance, s);
                         })
      .median;
}

/// The same of several engines: the least of at least eight rounds through all of them, of more where they are short.
std::vector<double> least_task_seconds(const std::vector<std::string>& names, const PhotonBatch& photons,
                                       const RadiusPolicy& policy, const QueryPoints& points) {
  constexpr int kFewestRounds = 8, kMostRounds = 40;
  constexpr double kEnoughSeconds = 1;
  std::vector<double> least;
  double spent = 0;
  for (int round = 0; round < kFewestRounds || (round < kMostRounds && spent < kEnoughSeconds); ++round)
    for (std::size_t e = 0; e < names.size(); ++e) {
      const double seconds = task_seconds(names[e], photons, policy, points);
      spent += seconds;
      if (round == 0)
        least.push_back(seconds);
      else
        least[e] = std::min(least[e], seconds);
    }
  return least;
}

void table_of_choices(const std::vector<std::string>& scenes) {
  Table table("density-auto",
              "What `auto` takes: building the map and all lookups, seconds (the least of several runs)",
              {"scene", "photons", "query points", "blocked", "forward", "reverse", "single", "auto takes",
               "auto over the best"});
  double worst = 0;
  for (const std::string& path : scenes) {
    const Recording recording = record(Stage(path), {1'000'000, 256, 256, 16});
    for (const std::size_t photon_count : {10'000u, 100'000u, 1'000'000u}) {
      PhotonBatch photons;
      for (std::size_t i = 0; i < std::min(photon_count, recording.photons.size()); ++i)
        photons.push_back(recording.photons.position[i], recording.photons.direction[i], recording.photons.flux[i],
                          recording.photons.normal[i]);
      RadiusPolicy policy;
      policy.radii = per_photon_radii(photons, 50);
      for (const std::size_t wanted : {1'000u, 30'000u, 1'000'000u}) {
        const QueryPoints points =
            runs_of(recording.points, {}, 1, std::max<std::size_t>(1, recording.points.size() / wanted));
        const auto n = static_cast<double>(points.size());
        const std::string chosen = choose_engine({static_cast<double>(photons.size()), n, n, 50});
        std::vector<Cell> cells = {short_name(path), Number{static_cast<double>(photons.size())}, Number{n}};
        std::vector<std::string> names = {"blocked", "forward", "reverse"};
        // A million points one by one take minutes that would tell no more.
        const bool all = wanted <= 100'000;
        if (all) names.emplace_back("single");
        const std::vector<double> seconds = least_task_seconds(names, photons, policy, points);
        const double best = *std::min_element(seconds.begin(), seconds.end());
        const double taken =
            seconds[static_cast<std::size_t>(std::find(names.begin(), names.end(), chosen) - names.begin())];
        for (const double of_engine : seconds) cells.push_back(Number{of_engine});
        if (!all) cells.push_back({});
        worst = std::max(worst, taken / best);
        cells.push_back(chosen);
        cells.push_back(Number{taken / best});
        table.add(std::move(cells));
      }
    }
  }
  table.note(
      fmt::format("`auto` chooses among the engines that sum photons within the photons' own radii; at worst it "
                  "took {:.2f} times the time of the best of them. A million points one by one were not measured.",
                  worst));
  table.write();
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  using namespace glowworm::bench;
  return run_tables("tables_engines", [&] {
    const Arguments asked(argc, argv);
    if (asked.wants("rates")) table_of_rates(asked.scenes());
    if (asked.wants("limits")) table_of_limits(asked.scenes_or_atrium());
    if (asked.wants("auto")) table_of_choices(asked.scenes());
  });
}
