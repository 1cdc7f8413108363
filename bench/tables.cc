// The tables of [SF07] and [HHS05], and of the window's sessions, with the papers' figures beside ours. Writes to
// bench/results/.
//
// usage: tables [PART]... [SCENE]...     (default: all parts, on table_scenes())
//   lanes    [SF07] Table 1: mean number of active lanes with and without reordering
//   render   [SF07] Table 2: the whole render against ray tracing alone
//   reorder  [SF07] Table 3: what reordering costs and what it saves
//   reverse  [HHS05] Table 1: whole renders by normal and by reverse photon mapping
//   view     [SF07] section 5.4: frames per second of an interactive session
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "control/job.h"
#include "core/parallel.h"
#include "density/forward.h"
#include "density/radius.h"
#include "session/camera_control.h"
#include "session/session.h"
#include "support/recording.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

// Lookups without reordering take minutes at full size: every kCut-th run of kRun points is looked up, and times are
// multiplied by what was left out.
constexpr std::size_t kRun = 8192, kCut = 16;
const ReorderSettings kPaperOrder{ReorderMethod::octree, 16, kAutomaticDepth};
const ReorderSettings kNoOrder{ReorderMethod::none, 0, 0};

using Scenes = std::vector<std::string>;

/// The k of [SF07]'s Table 2.
double paper_k(const std::string& scene) { return scene == "cornell" ? 60 : 45; }

/// A value of a table of [SF07], which measured Cornell and Sponza; other scenes stand beside Sponza's.
struct PaperValue {
  double cornell, sponza;
  Cell of(const std::string& scene) const { return Number{scene == "cornell" ? cornell : sponza}; }
};

/// The query points of a recording along the paper's order.
std::vector<std::uint32_t> paper_order(const Recording& recording) {
  return hilbert_order(recording.points.position, bounds_of(recording.points.position), recording.photons.size(),
                       kPaperOrder);
}

// [SF07] Table 1 -----------------------------------------------------------------------------------------------------

double active_lanes(const Recording& recording, const QueryPoints& points, const RadiusPolicy& policy, int lanes,
                    const ReorderSettings& reorder) {
  const auto engine = make_forward_engine({lanes, reorder});
  Statistics s;
  engine->build(recording.photons, recording.photons.flux, policy, s);
  look_up(*engine, points, s);
  return static_cast<double>(s.count(Counter::packet_active_lanes)) /
         static_cast<double>(s.count(Counter::packet_steps));
}

void table_of_lanes(const Scenes& scenes) {
  struct Row {
    std::uint32_t gather;
    PaperValue without, with;
  };
  constexpr Row kRows[] = {
      {16, {1.07, 1.41}, {2.84, 3.83}}, {64, {1.16, 1.72}, {3.32, 3.92}}, {100, {1.20, 1.84}, {3.41, 3.93}}};
  Table table("sf07-table1", "[SF07] Table 1: mean active lanes while a packet looks at a photon (256 x 256 pixels)",
              {"scene", "photons", "samples a pixel", "reordered", "paper, of 4", "of 4", "of 8", "of 16"});
  for (const std::string& path : scenes) {
    const Stage stage(path);
    const std::string scene = short_name(path);
    for (const std::uint64_t photons : {50'000u, 500'000u})
      for (const Row& row : kRows) {
        const Recording recording = record(stage, {photons, 256, 256, row.gather});
        const RadiusPolicy policy = fixed_radius_for(recording, paper_k(scene));
        const auto order = paper_order(recording);
        for (const bool reordered : {false, true}) {
          // Packets are not mixed by taking whole runs of them.
          const QueryPoints points =
              runs_of(recording.points, reordered ? order : std::vector<std::uint32_t>(), kRun, kCut);
          std::vector<Cell> cells = {scene, Number{static_cast<double>(photons)}, std::to_string(row.gather),
                                     reordered ? "yes" : "no", (reordered ? row.with : row.without).of(scene)};
          for (const int lanes : {4, 8, 16})
            cells.push_back(Number{active_lanes(recording, points, policy, lanes, reordered ? kPaperOrder : kNoOrder)});
          table.add(std::move(cells));
        }
      }
  }
  table.note(
      "One radius for all, with which a query point sees 60 (Cornell) or 45 photons in the mean, as in the paper's "
      "Table 2. The paper does not say how many photons its Table 1 rests on. \"Not reordered\" is the order in which "
      "final gathering leaves its points, by stratum and neighbourhood; the paper's came four of a cell at a time.");
  table.write();
}

// Whole renders: [SF07] Table 2, [HHS05] Table 1 ---------------------------------------------------------------------

/// What a render took, in wall seconds.
struct Rendered {
  double total, rays, photons, reorder, density, k;
};

Rendered render(const Stage& stage, const RenderSettings& settings) {
  Job job(stage.scene, stage.tracer, settings);
  job.wait();
  const Statistics& s = job.statistics();
  return {s.seconds(Phase::total),
          s.seconds(Phase::camera_pass) + s.seconds(Phase::gather_rays),
          s.seconds(Phase::trace_photons) + s.seconds(Phase::build_photon_map),
          s.seconds(Phase::reorder),
          s.seconds(Phase::density),
          mean_k(s)};
}

/// Indirect light alone, square pictures, 500,000 photons.
RenderSettings indirect_light(const std::string& engine, int side) {
  RenderSettings s;
  s.engine = engine;
  s.width = s.height = side;
  s.photons = 500'000;
  s.indirect_only = true;
  return s;
}

/// [SF07]'s renders, without what the paper does not have: guided photons, boundary correction, the secondary
/// gather.
RenderSettings sf07_settings(const std::string& engine, int side, std::uint32_t k) {
  RenderSettings s = indirect_light(engine, side);
  s.samples = 1;
  s.gather = 576;
  s.nearest = k;
  s.secondary_gather = s.boundary_correction = s.guiding = false;
  return s;
}

void table_of_renders(const Scenes& scenes) {
  Table table("sf07-table2", "[SF07] Table 2: a whole render of indirect light against ray tracing alone (576 samples)",
              {"scene", "engine", "pixels", "k", "ray tracing alone, s", "photons and map, s", "reordering, s",
               "lookups, s", "whole, s", "whole / ray tracing"});
  constexpr PaperValue kRays{65, 104}, kWhole{276, 235}, kRatio{276.0 / 65, 235.0 / 104};
  for (const std::string& path : scenes) {
    const std::string scene = short_name(path);
    table.add({scene,
               "the paper's, 1 core",
               "308 x 308",
               Number{paper_k(scene)},
               kRays.of(scene),
               {},
               {},
               {},
               kWhole.of(scene),
               kRatio.of(scene)});
    const Stage stage(path);
    double asked = paper_k(scene);  // the k to ask for, so that the mean comes out as the paper's
    for (int round = 0; round < 2; ++round)
      asked *= paper_k(scene) / render(stage, sf07_settings("auto", 32, static_cast<std::uint32_t>(asked + 0.5))).k;
    const auto add = [&](const char* engine, int side, int threads) {
      set_thread_count(threads);
      const Rendered r = render(stage, sf07_settings(engine, side, static_cast<std::uint32_t>(asked + 0.5)));
      table.add({scene, engine, fmt::format("{0} x {0}", side), Number{r.k}, Number{r.rays}, Number{r.photons},
                 Number{r.reorder}, Number{r.density}, Number{r.total}, Number{r.total / r.rays}});
    };
    add("blocked", 308, 1);
    add("blocked", 308, 0);
    add("forward", 77, 0);
    set_thread_count(0);
  }
  table.note(
      "500,000 photons, a radius for each; ray tracing alone is the camera pass and the gather rays of the same "
      "render. Pictures of 77 x 77 pixels hold a sixteenth of the paper's pixels.");
  table.write();
}

void table_of_reverse(const Scenes& scenes) {
  struct Published {
    const char* scene;
    int side;
    double normal, reverse;  // s
  };
  constexpr Published kPublished[] = {
      {"cornell", 300, 605, 420}, {"cornell", 500, 1540, 710}, {"sponza", 300, 840, 493}, {"sponza", 500, 2613, 1280}};
  constexpr int kMeasured = 90;
  Table table(
      "hhs05-table1", "[HHS05] Table 1: whole renders, 600 gather rays of each pixel",
      {"scene", "pixels", "normal, s", "reverse, s", "blocked, s", "k normal", "k reverse", "reverse over normal",
       "blocked over normal", "published normal, s", "published reverse, s", "published reverse over normal"});
  for (const std::string& path : scenes) {
    const Stage stage(path);
    const auto measure = [&](const char* engine) {
      RenderSettings s = indirect_light(engine, kMeasured);
      s.samples = 24;
      s.gather = 25;
      s.nearest = 50;  // the paper's K is between 30 and 65
      s.kernel = KernelShape::box;
      s.preference = Preference::quality;  // so that a small picture has as many query points at once as a large one
      return render(stage, s);
    };
    const Rendered normal = measure("knn"), reverse = measure("reverse"), blocked = measure("blocked");
    for (const int side : {300, 500}) {
      const auto whole = [&](const Rendered& r) {
        return r.photons + (r.total - r.photons) * std::pow(static_cast<double>(side) / kMeasured, 2);
      };
      const double n = whole(normal), r = whole(reverse), b = whole(blocked);
      std::vector<Cell> row = {short_name(path),  fmt::format("{0} x {0}", side),
                               Number{n},         Number{r},
                               Number{b},         Number{normal.k},
                               Number{reverse.k}, Number{n / r},
                               Number{n / b}};
      const auto* published = std::find_if(std::begin(kPublished), std::end(kPublished), [&](const Published& p) {
        return short_name(path) == p.scene && side == p.side;
      });
      if (published != std::end(kPublished))
        row.insert(row.end(), {Number{published->normal, 4}, Number{published->reverse, 4},
                               Number{published->normal / published->reverse}});
      else
        row.resize(row.size() + 3);
      table.add(std::move(row));
    }
  }
  table.note(fmt::format(
      "Indirect light alone, box kernel, 500,000 photons, radii for k = 50, photon pass counted. Measured at {0} x {0} "
      "pixels; all but the photon pass is multiplied by the number of pixels.",
      kMeasured));
  table.write();
}

// [SF07] Table 3 -----------------------------------------------------------------------------------------------------

void table_of_reordering(const Scenes& scenes) {
  constexpr int kRuns = 3;
  constexpr double kMean = 50;
  struct Row {
    std::uint32_t gather;
    PaperValue rays, none, single, packets, reorder;
  };
  constexpr Row kRows[] = {{64, {6.5, 6.5}, {9.5, 19.9}, {3.8, 12.23}, {3.1, 9.3}, {0.20, 0.36}},
                           {100, {10, 10}, {14.3, 28.8}, {5.8, 18.34}, {4.6, 13.6}, {0.33, 0.56}}};
  Table table("sf07-table3", "[SF07] Table 3: what reordering costs and what it saves (320 x 320 pixels, 2 M photons)",
              {"scene", "rays, millions", "engine", "not reordered, s", "reordered, single points, s",
               "reordered, packets, s", "time to reorder, s"});
  for (const std::string& path : scenes) {
    const Stage stage(path);
    const std::string scene = short_name(path);
    for (const Row& row : kRows) {
      const Recording recording = record(stage, {2'000'000, 320, 320, row.gather});
      table.add({scene, row.rays.of(scene), "the paper's", row.none.of(scene), row.single.of(scene),
                 row.packets.of(scene), row.reorder.of(scene)});
      const RadiusPolicy policy = fixed_radius_for(recording, kMean);
      const QueryPoints as_made = runs_of(recording.points, {}, kRun, kCut);
      const QueryPoints along = runs_of(recording.points, paper_order(recording), kRun, kCut);
      const auto seconds = [&](std::unique_ptr<DensityEngine> engine, const QueryPoints& points, Phase phase) {
        Statistics building;
        engine->build(recording.photons, recording.photons.flux, policy, building);
        std::vector<double> times;
        for (int run = 0; run < kRuns; ++run) {
          Statistics s;
          look_up(*engine, points, s);
          times.push_back(s.seconds(phase) * static_cast<double>(recording.points.size()) /
                          static_cast<double>(points.size()));
        }
        return spread_of(std::move(times));
      };
      const Number rays{1e-6 * static_cast<double>(recording.points.size())};
      table.add({scene, rays, "forward", seconds(make_forward_engine({0, kNoOrder}), as_made, Phase::density),
                 seconds(make_forward_engine({1, kPaperOrder}), along, Phase::density),
                 seconds(make_forward_engine({0, kPaperOrder}), along, Phase::density),
                 measure_seconds(kRuns, [&] { paper_order(recording); })});
      table.add({scene,
                 rays,
                 "blocked",
                 {},
                 {},
                 seconds(make_engine("blocked"), recording.points, Phase::density),
                 seconds(make_engine("blocked"), recording.points, Phase::reorder)});
    }
  }
  table.note(
      fmt::format("One radius for all, with which a query point sees {} photons in the mean. Lookups of the forward "
                  "engine: every {}th run of {} consecutive query points, times multiplied by what was left out; all "
                  "of the blocked engine's.",
                  kMean, kCut, kRun));
  table.write();
}

// Sessions: [SF07] section 5.4 ---------------------------------------------------------------------------------------

void table_of_views(const Scenes& scenes) {
  struct Row {
    ViewMode mode;
    std::uint32_t gather;
    int runs;
    const char *name, *paper;
  };
  constexpr Row kRows[] = {{ViewMode::photons, 1, 9, "photons shown", "10-11"},
                           {ViewMode::gather, 16, 5, "16 samples", "1.14"},
                           {ViewMode::gather, 64, 3, "64 samples", "0.34"},
                           {ViewMode::gather, 100, 3, "100 samples", "0.23"}};
  Table table("view", "Interactive sessions: 256 x 256 pixels, 500,000 photons, nothing reused across frames",
              {"scene", "mode", "redone", "frames/s", "[SF07], 4 cores, frames/s", "photons, ms", "map, ms",
               "camera, ms", "gather rays, ms", "density, ms"});
  for (const std::string& path : scenes) {
    Session session(Stage(path).scene, {});
    double clock = 0;
    for (const Row& row : kRows) {
      ViewState state = session.initial_state();
      state.width = state.height = 256;
      state.photons = 500'000;
      state.mode = row.mode;
      state.gather = row.gather;
      state.part = row.mode == ViewMode::photons ? LightPart::all : LightPart::indirect;
      state.secondary_gather = state.reuse = state.filter = false;
      session.next_frame(state, clock);
      for (const bool anew : {true, false}) {
        std::vector<double> seconds;
        std::vector<FrameCost> costs;
        for (int run = 0; run < row.runs; ++run) {
          // A step small enough that every frame sees the same scene.
          state.camera =
              fly(look(state.camera, nearest_up(state.camera), 0.002f, 0), {0.0005f * state.pivot_distance, 0, 0});
          if (anew) session.forget_photons();
          costs.push_back(session.next_frame(state, clock += 0.1).cost);
          seconds.push_back(costs.back().seconds);
        }
        const auto phases = [&](const std::vector<Phase>& of) {
          std::vector<double> values;
          for (const FrameCost& cost : costs) {
            values.push_back(0);
            for (const Phase phase : of) values.back() += 1e3 * cost.phase(phase);
          }
          return Number{spread_of(std::move(values)).median};
        };
        table.add({short_name(path), row.name, anew ? "all" : "camera alone", spread_of(seconds).rate(1), row.paper,
                   phases({Phase::trace_photons}), phases({Phase::build_photon_map}), phases({Phase::camera_pass}),
                   phases({Phase::gather_rays}), phases({Phase::reorder, Phase::density, Phase::completion})});
      }
    }
  }
  table.note("Indirect light from the map alone, as the paper shows it. Phases: medians of wall time.");
  table.write();
}

void write_tables(const std::set<std::string>& parts, const Scenes& scenes) {
  const struct {
    const char* part;
    void (*write)(const Scenes&);
  } tables[] = {{"lanes", table_of_lanes},
                {"render", table_of_renders},
                {"reorder", table_of_reordering},
                {"reverse", table_of_reverse},
                {"view", table_of_views}};
  for (const auto& table : tables)
    if (parts.empty() || parts.contains(table.part)) table.write(scenes);
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  std::set<std::string> parts;
  glowworm::bench::Scenes scenes;
  for (const std::string& word : std::vector<std::string>(argv + 1, argv + argc)) {
    if (word.find_first_of(":/.") == std::string::npos)
      parts.insert(word);
    else
      scenes.push_back(word);
  }
  try {
    glowworm::bench::write_tables(parts, scenes.empty() ? glowworm::bench::table_scenes() : scenes);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "tables: {}\n", error.what());
    return 1;
  }
}
