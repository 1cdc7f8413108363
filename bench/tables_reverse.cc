// The tables of [HHS05], with this program's engines: whole renders by normal, reverse and blocked photon mapping, time
// over memory and over photons, shares of time.
//
// usage: tables_reverse [scene:NAME]... [render|memory|photons|phases]... [side:N | full]
// All of them where none is named (under six minutes). Whole renders are measured at 90x90 pixels, or NxN; "full"
// renders the paper's pictures whole (an hour).
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "density/glossy.h"
#include "density/radius.h"
#include "density/reorder.h"
#include "import/import.h"
#include "render/job.h"
#include "support/nanoflann_tree.h"
#include "support/pair_cost.h"
#include "support/paper_render.h"
#include "support/recording.h"
#include "support/run_tables.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

constexpr int kUsualSide = 90;

std::vector<std::string> scene_paths() {
  std::vector<std::string> paths = {"builtin:cornell", "builtin:atrium", "builtin:ajar"};
  if (const std::string sponza = sponza_path(); !sponza.empty()) paths.push_back(sponza);
  for (const char* name :
       {"cornell-grey-pbrt/cornell-grey-reference.pbrt", "bitterli-cornell-box-pbrt/cornell-box-reference.pbrt",
        "bitterli-living-room-pbrt/living-room-reference.pbrt", "bitterli-staircase2-pbrt/staircase2-reference.pbrt",
        "bitterli-veach-ajar-pbrt/veach-ajar-reference.pbrt", "bitterli-veach-bidir-pbrt/veach-bidir-reference.pbrt"})
    if (const std::string path = shared_folder() + "/scenes/" + name; std::filesystem::exists(path))
      paths.push_back(path);
  return paths;
}

/// Seconds of normal and reverse photon mapping in Table 1 of the paper.
struct Published {
  const char* scene;
  int side;
  double normal, reverse;
};
constexpr Published kPublished[] = {
    {"cornell", 300, 605, 420}, {"cornell", 500, 1540, 710}, {"sponza", 300, 840, 493}, {"sponza", 500, 2613, 1280}};

/// A small part of a render's query points.
Recording small_recording(const std::string& path) {
  RecordingSettings settings;
  settings.width = settings.height = 60;
  settings.gather = kPaperRays / kPaperSamples;
  return record(Stage(path), settings);
}

/// Seconds of wall time that nanoflann's k nearest neighbours would take for each query point, summed up as normal
/// photon mapping does: the normal photon mapping that others would have.
double nanoflann_seconds(const Recording& recording) {
  ReorderSettings full;
  full.depth = 21;
  const PhotonBatch& photons = recording.photons;
  std::vector<Vec3> sorted;
  std::vector<RGB> flux;
  for (const std::uint32_t i : hilbert_order(photons.position, bounds_of(photons.position), 0, full)) {
    sorted.push_back(photons.position[i]);
    flux.push_back(photons.flux[i]);
  }
  if (sorted.size() < kPaperNearest || recording.points.size() == 0) return 0;
  const NanoflannPoints view{sorted};
  NanoflannTree tree(3, view, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  tree.buildIndex();
  const LargeVector<Vec3>& points = recording.points.position;
  const auto order = hilbert_order(points, bounds_of(points), 0, full);
  std::vector<RGB> radiance(points.size());
  const Spread seconds = measure_seconds(1, [&] {
    parallel_for(0, order.size(), 4096, [&](std::size_t first, std::size_t last) {
      std::vector<std::uint32_t> found(kPaperNearest);
      std::vector<float> distances(kPaperNearest);
      for (std::size_t i = first; i < last; ++i) {
        tree.knnSearch(&points[order[i]].x, kPaperNearest, found.data(), distances.data());
        RGB sum;
        for (const std::uint32_t photon : found) sum += flux[photon];
        radiance[order[i]] = sum / (distances.back() * kPi);
      }
    });
  });
  return seconds.median / static_cast<double>(points.size());
}

/// Shares of query points by how they are shaded.
struct Shares {
  double lambertian = 0, one_by_one = 0, glossy[kGlossyModels] = {};

  double not_lambertian() const { return one_by_one + glossy[0] + glossy[1] + glossy[2]; }

  explicit Shares(const QueryPoints& points) {
    const double each = 1 / static_cast<double>(std::max<std::size_t>(points.size(), 1));
    for (const std::uint32_t bsdf : points.bsdf) {
      if (bsdf == kLambertianQuery)
        lambertian += each;
      else if (const std::optional<GlossyModel> model = glossy_model(points.bsdfs[bsdf].bsdf))
        glossy[static_cast<std::size_t>(*model)] += each;
      else
        one_by_one += each;
    }
  }
};

/// Nanoseconds of a thread that the kernels of the reverse engine take for a pair where nothing is searched for.
struct PairCosts {
  double lambertian = nanoseconds_of_a_sum({});
  double glossy[kGlossyModels] = {nanoseconds_of_a_sum(GlossyModel::coated),
                                  nanoseconds_of_a_sum(GlossyModel::conductor),
                                  nanoseconds_of_a_sum(GlossyModel::schlick)};

  /// Of a pair of the points of a scene. Those shaded one by one count as if they were Lambertian.
  double of(const Shares& shares) const {
    double sum = (shares.lambertian + shares.one_by_one) * lambertian;
    for (std::size_t m = 0; m < kGlossyModels; ++m) sum += shares.glossy[m] * glossy[m];
    return sum;
  }
};

/// What keeps the reverse engine from being 8 times as fast as the normal render: the first that alone does.
const char* what_limits(double ratio, double rays, double sums, double tests) {
  constexpr double kAsked = 8;
  if (ratio >= kAsked) return "nothing";
  if (rays < kAsked) return "rays";
  if (sums < kAsked) return "sums";
  if (tests < kAsked) return "tests";
  return "searching";
}

/// Table 1: whole renders.
void table_render(bool full, int usual_side, const std::set<std::string>& parts) {
  Table table("hhs05_render", "Whole renders, 600 gather rays of each pixel ([HHS05], Table 1)",
              {"scene",
               "pixels",
               "measured at",
               "normal, s",
               "normal by nanoflann, s",
               "reverse, s",
               "blocked, s",
               "k normal",
               "k reverse",
               "reverse over normal",
               "reverse over nanoflann's",
               "blocked over normal",
               "blocked over nanoflann's",
               "no engine over normal more than",
               "over nanoflann's",
               "glossy points, %",
               "sums alone, s",
               "with rays and sums alone",
               "tests and sums alone, s",
               "with rays, tests and sums alone",
               "8 times would leave for all else, ns a query point",
               "8 times is kept from by",
               "looking up: reverse over normal",
               "looking up: blocked over normal",
               "all but looking up, s",
               "published normal, s",
               "published reverse, s",
               "published speed-up"});
  const PairCosts costs;
  const bool chosen =
      std::any_of(parts.begin(), parts.end(), [](const std::string& p) { return p.starts_with("scene:"); });
  for (const std::string& path : scene_paths()) {
    const std::string name = short_name(path);
    if (chosen && parts.count("scene:" + name) == 0) continue;
    const Recording recording = small_recording(path);
    const Shares shares(recording.points);
    const double nanoflann = nanoflann_seconds(recording), pair = costs.of(shares) * 1e-9 / thread_count();
    const RenderedScene set(path);
    RenderTimes normal, reverse, blocked;
    for (const int side : {300, 500}) {
      const int measured = full ? side : usual_side;
      const double factor = std::pow(static_cast<double>(side) / measured, 2);
      if (full || side == 300) {
        normal = render(set, paper_settings("knn", measured));
        reverse = render(set, paper_settings("reverse", measured));
        blocked = render(set, paper_settings("blocked", measured));
      }
      const double queries = static_cast<double>(normal.queries);
      // What no engine takes less than: all but looking up, by the run that took the least for it.
      const double rays =
          std::min({normal.whole(factor) - normal.look_up * factor, reverse.whole(factor) - reverse.look_up * factor,
                    blocked.whole(factor) - blocked.look_up * factor});
      const double n = normal.whole(factor), r = reverse.whole(factor), b = blocked.whole(factor),
                   other = n + (queries * nanoflann - normal.look_up) * factor;
      const double sums = queries * factor * reverse.k * pair, tests = queries * factor * reverse.tested * pair;
      std::vector<Cell> row = {name,
                               fmt::format("{0}x{0}", side),
                               fmt::format("{0}x{0}", measured),
                               Number{n},
                               Number{other},
                               Number{r},
                               Number{b},
                               Number{normal.k},
                               Number{reverse.k},
                               Number{n / r},
                               Number{other / r},
                               Number{n / b},
                               Number{other / b},
                               Number{n / rays},
                               Number{other / rays},
                               Number{100 * shares.not_lambertian(), 2},
                               Number{sums},
                               Number{n / (rays + sums)},
                               Number{tests},
                               Number{n / (rays + tests)},
                               Number{1e9 * thread_count() * (n / 8 - rays - tests) / (queries * factor)},
                               what_limits(n / r, n / rays, n / (rays + sums), n / (rays + tests)),
                               Number{normal.look_up / reverse.look_up},
                               Number{normal.look_up / blocked.look_up},
                               Number{rays}};
      const auto* published = std::find_if(std::begin(kPublished), std::end(kPublished),
                                           [&](const Published& p) { return name == p.scene && side == p.side; });
      if (published != std::end(kPublished))
        row.insert(row.end(), {Number{published->normal, 4}, Number{published->reverse, 4},
                               Number{published->normal / published->reverse}});
      else
        row.insert(row.end(), {Cell(), Cell(), Cell()});
      table.add(row);
    }
  }
  table.note("Indirect light alone, box kernel, 500,000 photons, radii for k = 50, photon pass counted.");
  table.note(
      "Normal by nanoflann: the same render, with the time that nanoflann's k nearest neighbours and their sum take "
      "for "
      "as many query points in place of the program's; its tree is not counted, nor are normals compared.");
  table.note(fmt::format(
      "Sums alone: as many pairs as the reverse engine adds up, at {:.3f} ns of a thread for a Lambertian point, "
      "{:.3f}, "
      "{:.3f} and {:.3f} for coated, conducting and Schlick's ones, as its kernels take where nothing is searched for "
      "and all is in the nearest cache; tests and sums: as many as it tests. Beside them the ratio that would be "
      "reached if looking up took that long, and the time of a thread that 8 times would leave for trees, search, "
      "order and completion together. The first of these below 8 is what keeps from 8 times.",
      costs.lambertian, costs.glossy[0], costs.glossy[1], costs.glossy[2]));
  table.note("No engine over normal more than: the normal render over all of it but looking up, by the fastest run.");
  if (!full)
    table.note(fmt::format(
        "Measured at {0}x{0} pixels; what grows with the pixels is multiplied (by {1:.3g} and {2:.3g}), the photon "
        "pass "
        "is not. So is what a process spends once on memory that is new to it, which flatters no engine but `knn`.",
        usual_side, std::pow(300.0 / usual_side, 2), std::pow(500.0 / usual_side, 2)));
  table.write();
}

/// Table 2: memory against tasks and time.
void table_memory() {
  Table table("hhs05_memory", "Time over memory, atrium, 283x283 pixels, 100 gather rays each ([HHS05], Table 2)",
              {"engine", "memory, MB", "on disk", "tasks", "held beside the scene, MB", "time, s",
               "over that of the most memory"});
  const RenderedScene set("builtin:atrium");
  keep_heap_small();  // as the program does with a small budget; else one render would leave its memory to the next
  for (const char* engine : {"reverse", "blocked"}) {
    double most = 0;
    struct Memory {
      std::uint64_t megabytes;
      DiskUse disk;
    };
    std::vector<Memory> memories = {{4000, DiskUse::never}, {1000, DiskUse::never}, {400, DiskUse::never}};
    if (std::string(engine) == "reverse")
      memories.insert(memories.end(),
                      {{200, DiskUse::never}, {400, DiskUse::always}, {200, DiskUse::always}, {100, DiskUse::always}});
    for (const auto& [megabytes, disk] : memories) {
      RenderSettings settings = paper_settings(engine, 283);
      settings.samples = 1;
      settings.gather = 100;
      settings.photons = 200'000;
      settings.memory_bytes = megabytes * 1'000'000;
      settings.disk = disk;
      const RenderTimes r = render(set, settings);
      const double seconds = r.whole(1);
      if (most == 0) most = seconds;
      table.add({engine, Number{static_cast<double>(megabytes), 4}, disk == DiskUse::always ? "yes" : "no",
                 Number{static_cast<double>(r.tasks), 4}, Number{static_cast<double>(r.peak) / 1e6}, Number{seconds},
                 Number{seconds / most}});
    }
  }
  table.note("200,000 photons. The scene itself, and what rays are traced against, are not in the budget.");
  table.write();
}

/// Time over the number of photons.
void table_photons() {
  Table table("hhs05_photons", "Time over photons, atrium, 600 gather rays of each pixel",
              {"engine", "photons", "photon pass, s", "at 250x250: rays and look-up, s", "look-up, s", "k",
               "whole at 500x500, s", "over that of the fewest"});
  const RenderedScene set("builtin:atrium");
  // So large that memory written for the first time counts little, as it does in the whole.
  constexpr int kSide = 250;
  for (const char* engine : {"reverse", "blocked"}) {
    double fewest = 0;
    for (const std::uint64_t photons : {100'000, 300'000, 1'000'000}) {
      RenderSettings settings = paper_settings(engine, kSide);
      settings.photons = photons;
      const RenderTimes r = render(set, settings);
      const double whole = r.whole(500.0 * 500 / (kSide * kSide));
      if (fewest == 0) fewest = whole;
      table.add({engine, Number{static_cast<double>(photons), 7}, Number{r.photons}, Number{r.rest}, Number{r.look_up},
                 Number{r.k}, Number{whole}, Number{whole / fewest}});
    }
  }
  table.note("Radii for k = 50 whatever the number. The whole at 500x500 is reckoned: pixels times 4.");
  table.write();
}

/// Shares of time by phase.
void table_phases() {
  constexpr Phase kPhases[] = {Phase::trace_photons, Phase::build_photon_map, Phase::camera_pass, Phase::gather_rays,
                               Phase::reorder,       Phase::density,          Phase::completion};
  std::vector<std::string> columns = {"engine", "time, s"};
  for (const Phase phase : kPhases) columns.push_back(fmt::format("{}, %", name(phase)));
  Table table("hhs05_phases", "Share of time by phase, atrium, 90x90 pixels, 600 gather rays each", columns);
  const RenderedScene set("builtin:atrium");
  for (const char* engine : {"knn", "reverse", "blocked", "forward"}) {
    Job job(set.scene, set.tracer, paper_settings(engine, 90));
    job.wait();
    const Statistics& s = job.statistics();
    std::vector<Cell> row = {engine, Number{s.seconds(Phase::total)}};
    for (const Phase phase : kPhases) row.push_back(Number{100 * s.seconds(phase) / s.seconds(Phase::total), 2});
    table.add(row);
  }
  table.note(
      "Published: normal: kNN 70, density 15, rays 10, sampling 3; reverse: search 20 to 25, density 37, rays 20, "
      "trees 8, sampling 6.");
  table.write();
}

/// Pixels along a side of the pictures that whole renders are measured at.
int side_of(const std::set<std::string>& parts) {
  for (const std::string& part : parts) {
    if (!part.starts_with("side:")) continue;
    int side = 0;
    const char* const end = part.data() + part.size();
    if (std::from_chars(part.data() + 5, end, side).ptr != end || side < 1)
      throw Error(fmt::format("'{}' is no side of a picture", part), "Give a number of pixels, as side:150.");
    return side;
  }
  return kUsualSide;
}

void write_tables(const std::set<std::string>& parts) {
  const bool any = std::any_of(parts.begin(), parts.end(), [](const std::string& p) {
    return p != "full" && !p.starts_with("scene:") && !p.starts_with("side:");
  });
  const auto wanted = [&](const char* part) { return !any || parts.count(part) > 0; };
  if (wanted("render")) table_render(parts.count("full") > 0, side_of(parts), parts);
  if (wanted("memory")) table_memory();
  if (wanted("photons")) table_photons();
  if (wanted("phases")) table_phases();
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  return glowworm::bench::run_tables("tables_reverse", [&] { glowworm::bench::write_tables({argv + 1, argv + argc}); });
}
