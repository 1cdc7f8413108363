// The tables of [SF07], regenerated: the paper's engine (forward) and ours (blocked) on the scenes of table_scenes(),
// at the paper's resolution, samples, photons and k, with the paper's figures beside ours. Writes to bench/results/.
//
// usage: tables_forward [lanes] [packets] [render] [widths] [reorder] [depth] [SCENE]...     (default: all, on those of
// table_scenes())
//   lanes    Table 1: mean number of active lanes with and without reordering
//   packets  what the order of query points has to do with active lanes
//   render   Table 2: the whole render against ray tracing alone
//   widths   the same of small pictures, by engine and instruction set
//   reorder  Table 3: what reordering costs and what it saves
//   depth    the paper's open question: time of reordering and lookups over the depth of the order
//
// Lookups that the reordering does not help, and those of single points, take minutes at full size: of these every
// kCut-th run of kRun points is looked up, and times are multiplied by what was left out; the tables mark them.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "density/forward.h"
#include "density/reorder.h"
#include "import/import.h"
#include "kernels/simd.h"
#include "render/job.h"
#include "support/arguments.h"
#include "support/calibration.h"
#include "support/recording.h"
#include "support/run_tables.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

constexpr std::size_t kRun = 8192, kCut = 16;
const ReorderSettings kPaperOrder{ReorderMethod::octree, 16, kAutomaticDepth};
const ReorderSettings kNoOrder{ReorderMethod::none, 0, 0};

double mean_k(const Statistics& s) {
  return static_cast<double>(s.count(Counter::shader_operations)) / static_cast<double>(s.count(Counter::query_points));
}

/// The k of [SF07]'s Table 2.
double paper_k(const std::string& scene) { return scene == "cornell" ? 60 : 45; }

/// A value of a table of the paper, which measured Cornell and Sponza; the atrium is held against Sponza.
struct PaperValue {
  double cornell, sponza;
  Cell of(const std::string& scene) const { return Number{scene == "cornell" ? cornell : sponza}; }
};

// Table 1 ------------------------------------------------------------------------------------------------------------

struct LanesRow {
  std::uint32_t gather;
  PaperValue without, with;
};
const LanesRow kLanesRows[] = {{0, {3.18, 3.74}, {0, 0}},
                               {16, {1.07, 1.41}, {2.84, 3.83}},
                               {64, {1.16, 1.72}, {3.32, 3.92}},
                               {100, {1.20, 1.84}, {3.41, 3.93}}};

double active_lanes(const Recording& recording, const QueryPoints& points, const RadiusPolicy& policy, int lanes,
                    const ReorderSettings& reorder) {
  const auto engine = make_forward_engine({lanes, reorder});
  Statistics statistics;
  engine->build(recording.photons, policy, statistics);
  std::vector<RGB> radiance(points.size());
  engine->estimate(points, radiance, statistics);
  return static_cast<double>(statistics.count(Counter::packet_active_lanes)) /
         static_cast<double>(statistics.count(Counter::packet_steps));
}

void table_of_lanes(const std::vector<std::string>& scenes) {
  Table table("sf07-table1", "[SF07] Table 1: mean active lanes while a packet looks at a photon (256 x 256 pixels)",
              {"scene", "photons", "samples a pixel", "reordered", "paper, of 4", "of 4", "of 8", "of 16"});
  for (const std::string& path : scenes) {
    const Stage stage(path);
    const std::string scene = short_name(path);
    for (const std::uint64_t photons : {50'000u, 500'000u}) {
      for (const LanesRow& row : kLanesRows) {
        if (row.gather == 0 && photons > 50'000) continue;
        const Recording recording = record(stage, {photons, 256, 256, row.gather});
        const RadiusPolicy policy = fixed_radius_for(recording, paper_k(scene));
        const auto order = hilbert_order(recording.points.position, bounds_of(recording.points.position),
                                         recording.photons.size(), kPaperOrder);
        // Packets are not mixed by taking whole runs of them.
        const std::size_t cut = row.gather == 0 ? 1 : kCut;
        for (const bool reordered : {false, true}) {
          const QueryPoints points =
              runs_of(recording.points, reordered ? order : std::vector<std::uint32_t>(), kRun, cut);
          std::vector<Cell> cells = {scene, Number{static_cast<double>(photons)},
                                     row.gather == 0 ? "photons shown directly" : std::to_string(row.gather),
                                     reordered ? "yes" : "no"};
          if (reordered && row.gather == 0)
            cells.push_back({});
          else
            cells.push_back((reordered ? row.with : row.without).of(scene));
          for (const int lanes : {4, 8, 16})
            cells.push_back(Number{active_lanes(recording, points, policy, lanes, reordered ? kPaperOrder : kNoOrder)});
          table.add(std::move(cells));
        }
      }
    }
  }
  table.note(fmt::format(
      "One radius for all, with which a query point sees 60 (Cornell) or 45 photons in the mean, as in the paper's "
      "Table "
      "2. Packets of 8 and 16 are made of several vectors where the machine's are shorter. Every {}th run of {} "
      "consecutive query points is looked at.",
      kCut, kRun));
  table.note(
      "The paper does not say how many photons its Table 1 rests on; its sessions at this size show 10 to 11 frames a "
      "second with photons traced and sorted anew, which at its own rates leaves time for some 50,000. Fewer photons "
      "are "
      "wider ones, which fill more lanes.");
  table.note(
      "\"Not reordered\" is the order in which final gathering leaves its points, which are traced by stratum and "
      "neighbourhood; the paper's came four of a cell at a time.");
  table.write();
}

/// Brings indices into an order whose aligned runs of `lanes` are as compact as halving along the longest side of
/// their box makes them.
void halve(std::span<std::uint32_t> order, std::span<const Vec3> positions, std::size_t lanes) {
  if (order.size() <= lanes) return;
  Box3 box;
  for (const std::uint32_t i : order) box.grow(positions[i]);
  const int axis = box.longest_axis();
  const std::size_t half = lanes * std::bit_floor((order.size() - 1) / lanes);
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return positions[a][axis] < positions[b][axis]; });
  halve(order.first(half), positions, lanes);
  halve(order.subspan(half), positions, lanes);
}

/// What the order of query points has to do with active lanes: that of the paper, the same to the last point, and
/// packets that are as compact as can be.
void table_of_lane_limits(const std::vector<std::string>& scenes) {
  Table table("sf07-table1-limits", "Mean active lanes by the order of query points (256 x 256 pixels)",
              {"scene", "samples a pixel", "photons", "query points in a photon's disc", "paper, of 4",
               "its order, of 4", "complete order, of 4", "packets halved out, of 4", "its order, of 16",
               "complete order, of 16", "packets halved out, of 16"});
  const ReorderSettings complete{ReorderMethod::octree, 1, kAutomaticDepth};
  for (const std::string& path : scenes) {
    const Stage stage(path);
    const std::string scene = short_name(path);
    for (const LanesRow& row : {kLanesRows[1], kLanesRows[3]})
      for (const std::uint64_t photons : {200'000u, 500'000u}) {
        const Recording recording = record(stage, {photons, 256, 256, row.gather});
        const double k = paper_k(scene);
        const RadiusPolicy policy = fixed_radius_for(recording, k);
        const auto order = hilbert_order(recording.points.position, bounds_of(recording.points.position),
                                         recording.photons.size(), kPaperOrder);
        const QueryPoints points = runs_of(recording.points, order, kRun, kCut);
        std::vector<Cell> cells = {
            scene, std::to_string(row.gather), Number{static_cast<double>(photons)},
            Number{k * static_cast<double>(recording.points.size()) / static_cast<double>(recording.photons.size())},
            row.with.of(scene)};
        for (const int lanes : {4, 16}) {
          std::vector<std::uint32_t> halved(points.size());
          std::iota(halved.begin(), halved.end(), 0u);
          halve(halved, points.position, static_cast<std::size_t>(lanes));
          cells.push_back(Number{active_lanes(recording, points, policy, lanes, kPaperOrder)});
          cells.push_back(Number{active_lanes(recording, points, policy, lanes, complete)});
          cells.push_back(Number{active_lanes(recording, in_order(points, halved), policy, lanes, kNoOrder)});
        }
        table.add(std::move(cells));
      }
  }
  table.note(
      "Packets halved out: every cell is cut along its longest side into parts of whole packets, down to packets of "
      "the "
      "points that lie nearest each other. A photon's disc: of the one radius for all.");
  table.write();
}

// Table 2 ------------------------------------------------------------------------------------------------------------

/// What renders took, in wall seconds, and what follows from it, each run for itself.
struct Rendered {
  std::vector<double> total, rays, photons, reorder, density, ratio, without_lookups, without_photons, rate;
  double k = 0;
};

struct SharedStage {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;
};

/// Renders indirect light alone, as the paper did.
/// @param bare without what the paper had not: guided photons, boundary correction, second gathering in corners
Rendered render(const SharedStage& stage, const std::string& engine, int side, std::uint32_t k, bool bare, int runs) {
  RenderSettings settings;
  settings.engine = engine;
  settings.samples = 1;
  settings.gather = 576;
  settings.photons = 500'000;
  settings.nearest = k;
  settings.width = settings.height = side;
  settings.indirect_only = true;
  settings.secondary_gather = settings.boundary_correction = settings.guiding = !bare;
  settings.threads = thread_count();
  Rendered r;
  for (int run = 0; run < runs; ++run) {
    Job job(stage.scene, stage.tracer, settings);
    job.wait();
    const Statistics& s = job.statistics();
    r.k = mean_k(s);
    r.total.push_back(job.seconds());
    r.rays.push_back(s.seconds(Phase::camera_pass) + s.seconds(Phase::gather_rays));
    r.photons.push_back(s.seconds(Phase::trace_photons) + s.seconds(Phase::build_photon_map));
    r.reorder.push_back(s.seconds(Phase::reorder));
    r.density.push_back(s.seconds(Phase::density));
    const double look_up = r.reorder.back() + r.density.back();
    r.ratio.push_back(r.total.back() / r.rays.back());
    r.without_lookups.push_back((r.total.back() - look_up) / r.rays.back());
    r.without_photons.push_back((r.total.back() - r.photons.back()) / r.rays.back());
    r.rate.push_back(1e-6 * static_cast<double>(s.count(Counter::shader_operations)) / look_up / thread_count());
  }
  return r;
}

/// The k to ask for, so that the mean comes out as the paper's.
std::uint32_t asked_k(const SharedStage& stage, double wanted) {
  double asked = wanted;
  for (int round = 0; round < 2; ++round)
    asked *= wanted / render(stage, "blocked", 32, static_cast<std::uint32_t>(asked + 0.5), true, 1).k;
  return static_cast<std::uint32_t>(asked + 0.5);
}

/// @param small pictures of a sixteenth of the paper's pixels, by both engines and on every instruction set
void table_of_renders(const std::vector<std::string>& scenes, bool small) {
  Table table(small ? "sf07-table2-widths" : "sf07-table2",
              fmt::format("[SF07] Table 2{}: a whole render of indirect light against ray tracing alone (576 samples)",
                          small ? ", by engine and instruction set" : ""),
              {"scene", "engine", "pixels", "k", "ray tracing alone, s", "photons and map, s", "reordering, s",
               "lookups, s", "whole, s", "whole / ray tracing", "the same, lookups and reordering free",
               "the same, photons and map free", "million shader operations a second a core"});
  for (const std::string& path : scenes) {
    const std::string scene = short_name(path);
    const bool cornell = scene == "cornell";
    for (const int cores : {1, 2}) {
      if (small) break;
      table.add({scene,
                 fmt::format("the paper's, {} core{}", cores, cores > 1 ? "s" : ""),
                 "308 x 308",
                 Number{paper_k(scene)},
                 cores > 1 ? Cell() : Cell(Number{cornell ? 65.0 : 104.0}),
                 {},
                 {},
                 {},
                 Number{cornell ? (cores > 1 ? 146.0 : 276.0) : (cores > 1 ? 118.0 : 235.0)},
                 cores > 1 ? Cell() : Cell(Number{cornell ? 276.0 / 65 : 235.0 / 104}),
                 {},
                 {},
                 Number{cornell ? 11.0 : 10.0}});
    }
    SharedStage stage;
    stage.scene = std::make_shared<const Scene>(load_scene(path));
    stage.tracer = std::make_shared<const Tracer>(*stage.scene);
    const std::uint32_t k = asked_k(stage, paper_k(scene));
    const auto row = [&](const std::string& engine, int side, int threads, bool bare, int runs) {
      set_thread_count(threads);
      const Rendered r = render(stage, engine, side, k, bare, runs);
      table.add({scene, bare ? engine : engine + ", by default", fmt::format("{0} x {0}", side), Number{r.k},
                 spread_of(r.rays), spread_of(r.photons), spread_of(r.reorder), spread_of(r.density),
                 spread_of(r.total), spread_of(r.ratio), spread_of(r.without_lookups), spread_of(r.without_photons),
                 spread_of(r.rate)});
    };
    if (!small) {
      for (const int threads : {2, 1}) row("blocked", 308, threads, true, 2);
      row("blocked", 308, 2, false, 1);
      set_thread_count(0);
      continue;
    }
    for (const std::string& simd : simd_names()) {
      if (simd == "ssse3") continue;  // differs from SSE4 in nothing that is used here
      set_simd(simd);
      for (const int threads : {2, 1})
        for (const char* engine : {"forward", "blocked"}) row(engine, 77, threads, true, 2);
    }
    set_simd("auto");
    set_thread_count(0);
  }
  table.note(
      "500,000 photons, a radius for each; ray tracing alone is the camera pass and the gather rays of the same "
      "render.");
  if (small) table.note("Pictures of 77 x 77 pixels hold a sixteenth of the paper's pixels.");
  table.write();
}

// Table 3 ------------------------------------------------------------------------------------------------------------

struct ReorderRow {
  std::uint32_t gather;
  PaperValue none, single, simd, reorder;
};
const ReorderRow kReorderRows[] = {{64, {9.5, 19.9}, {3.8, 12.23}, {3.1, 9.3}, {0.20, 0.36}},
                                   {100, {14.3, 28.8}, {5.8, 18.34}, {4.6, 13.6}, {0.33, 0.56}}};
constexpr double kReorderK = 50;

/// Seconds of lookups, all of them or as if all had been looked up.
Spread lookups(const Recording& recording, const QueryPoints& points, const DensityEngine& engine, int runs) {
  std::vector<RGB> radiance(points.size());
  std::vector<double> seconds;
  for (int i = 0; i < runs; ++i) {
    Statistics s;
    engine.estimate(points, radiance, s);
    seconds.push_back(s.seconds(Phase::density) * static_cast<double>(recording.points.size()) /
                      static_cast<double>(points.size()));
  }
  return spread_of(seconds);
}

void table_of_reordering(const std::vector<std::string>& scenes) {
  Table table("sf07-table3", "[SF07] Table 3: what reordering costs and what it saves (320 x 320 pixels, 2 M photons)",
              {"scene", "rays, millions", "engine", "not reordered, s", "reordered, single points, s",
               "reordered, packets, s", "time to reorder, s"});
  for (const std::string& path : scenes) {
    const Stage stage(path);
    const std::string scene = short_name(path);
    for (const ReorderRow& row : kReorderRows) {
      const Recording recording = record(stage, {2'000'000, 320, 320, row.gather});
      const Number rays{1e-6 * static_cast<double>(recording.points.size())};
      table.add({scene, Number{row.gather == 64 ? 6.5 : 10.0}, "the paper's", row.none.of(scene), row.single.of(scene),
                 row.simd.of(scene), row.reorder.of(scene)});
      const RadiusPolicy policy = fixed_radius_for(recording, kReorderK);
      Statistics building;
      const auto order = hilbert_order(recording.points.position, bounds_of(recording.points.position),
                                       recording.photons.size(), kPaperOrder);
      const QueryPoints as_made = runs_of(recording.points, {}, kRun, kCut);
      const QueryPoints along = runs_of(recording.points, order, kRun, kCut);
      const auto single = make_forward_engine({1, kPaperOrder});
      single->build(recording.photons, policy, building);
      const auto unordered = make_forward_engine({0, kNoOrder});
      unordered->build(recording.photons, policy, building);
      const auto packets = make_forward_engine({0, kPaperOrder});
      packets->build(recording.photons, policy, building);
      const auto blocked = make_engine("blocked");
      blocked->build(recording.photons, policy, building);
      const auto add = [&](const std::string& simd, int threads) {
        set_simd(simd);
        set_thread_count(threads);
        const int runs = simd == simd_names().front() ? 3 : 2;
        const Spread reorder = measure_seconds(runs, [&] {
          hilbert_order(recording.points.position, bounds_of(recording.points.position), recording.photons.size(),
                        kPaperOrder);
        });
        table.add({scene, rays, "forward", lookups(recording, as_made, *unordered, runs),
                   lookups(recording, along, *single, runs), lookups(recording, along, *packets, runs), reorder});
        std::vector<double> query, sort;
        std::vector<RGB> radiance(recording.points.size());
        for (int i = 0; i < runs; ++i) {
          Statistics s;
          blocked->estimate(recording.points, radiance, s);
          query.push_back(s.seconds(Phase::density));
          sort.push_back(s.seconds(Phase::reorder));
        }
        table.add({scene, rays, "blocked", {}, {}, spread_of(query), spread_of(sort)});
      };
      for (const std::string& simd : simd_names()) {
        if (simd == "ssse3") continue;
        for (const int threads : {2, 1}) add(simd, threads);
      }
      set_simd("auto");
      set_thread_count(0);
    }
  }
  table.note(
      fmt::format("One radius for all, with which a query point sees {} photons in the mean. Lookups of the "
                  "forward engine: every {}th run of {} consecutive query points, times multiplied by what was "
                  "left out; all of the blocked engine's.",
                  kReorderK, kCut, kRun));
  table.write();
}

// The depth of the order ---------------------------------------------------------------------------------------------

void table_of_depths(const std::vector<std::string>& scenes) {
  Table table("reorder-depth",
              "Reordering and lookups over the depth of the order (forward engine, 320 x 320, 16 rays)",
              {"scene", "photons", "method", "depth or threshold", "reordering, s", "lookups, s", "sum, s",
               "active lanes", "chosen"});
  for (const std::string& path : scenes) {
    const Stage stage(path);
    const std::string scene = short_name(path);
    for (const std::uint64_t photons : {100'000u, 1'000'000u}) {
      const Recording recording = record(stage, {photons, 320, 320, 16});
      const RadiusPolicy policy = fixed_radius_for(recording, kReorderK);
      const int chosen = automatic_depth(recording.points.size(), recording.photons.size());
      std::vector<RGB> radiance(recording.points.size());
      const auto add = [&](const char* method, const ReorderSettings& settings, int shown, bool is_chosen) {
        const auto engine = make_forward_engine({0, settings});
        Statistics building;
        engine->build(recording.photons, policy, building);
        std::vector<double> reorder, query, sum;
        double lanes = 0;
        for (int i = 0; i < 2; ++i) {
          Statistics s;
          engine->estimate(recording.points, radiance, s);
          reorder.push_back(s.seconds(Phase::reorder));
          query.push_back(s.seconds(Phase::density));
          sum.push_back(reorder.back() + query.back());
          lanes = static_cast<double>(s.count(Counter::packet_active_lanes)) /
                  static_cast<double>(s.count(Counter::packet_steps));
        }
        table.add({scene, Number{static_cast<double>(photons)}, method, Number{static_cast<double>(shown)},
                   spread_of(reorder), spread_of(query), spread_of(sum), Number{lanes}, is_chosen ? "auto" : ""});
      };
      for (int depth = 3; depth <= 11; ++depth) add("radix", {ReorderMethod::radix, 0, depth}, depth, depth == chosen);
      for (const std::uint32_t threshold : {2u, 4u, 8u, 16u, 64u})
        add("octree", {ReorderMethod::octree, threshold, kAutomaticDepth}, static_cast<int>(threshold), false);
    }
  }
  table.write();
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  using namespace glowworm::bench;
  return run_tables("tables_forward", [&] {
    const Arguments asked(argc, argv);
    if (asked.wants("lanes")) table_of_lanes(asked.scenes());
    if (asked.wants("packets")) table_of_lane_limits(asked.scenes());
    if (asked.wants("render")) table_of_renders(asked.scenes(), false);
    if (asked.wants("widths")) table_of_renders(asked.scenes(), true);
    if (asked.wants("reorder")) table_of_reordering(asked.scenes());
    if (asked.wants("depth")) table_of_depths(asked.scenes());
  });
}
