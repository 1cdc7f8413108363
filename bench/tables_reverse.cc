// The tables of [HHS05], with this program's engines: whole renders by normal, reverse and blocked photon mapping, time
// over memory and over photons, shares of time, and the two renders that are held to a limit.
// usage: tables_reverse [scene:NAME]... [render|memory|photons|phases|grey|atrium]...   all of them where none is
// named; "full" measures render's sizes as they are instead of a part of their pixels (an hour).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/memory_budget.h"
#include "core/parallel.h"
#include "image/metrics.h"
#include "import/import.h"
#include "render/job.h"
#include "render/output.h"
#include "support/recording.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

constexpr std::uint32_t kGatherRays = 600;  // of a pixel, as in the paper
constexpr std::uint32_t kSamples = 24;      // camera samples, which share them out

/// A scene that any number of renders use.
struct Set {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;
  explicit Set(const std::string& path)
      : scene(std::make_shared<const Scene>(load_scene(path))), tracer(std::make_shared<const Tracer>(*scene)) {}
};

/// Folder of the scenes that are handed around beside the project; empty where it is not there.
std::string shared_folder() {
  for (const char* folder : {"../shared", "../../shared", "/work/shared"})
    if (std::filesystem::exists(std::string(folder) + "/scenes")) return folder;
  return {};
}

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

/// The paper's settings: indirect light alone, box kernel, 600 gather rays a pixel.
RenderSettings paper_settings(const char* engine, int side) {
  RenderSettings s;
  s.engine = engine;
  s.width = s.height = side;
  s.samples = kSamples;
  s.gather = kGatherRays / kSamples;
  s.photons = 500'000;
  s.nearest = 50;  // the paper's K is between 30 and 65
  s.kernel = KernelShape::box;
  s.indirect_only = true;
  s.separate_layers = false;
  return s;
}

/// What a render took, in wall seconds.
struct Run {
  double photons = 0;  ///< tracing them and building their map
  double rest = 0;     ///< all that grows with the pixels
  double look_up = 0;  ///< of it, reordering and density estimation
  double k = 0;        ///< shader operations of a query point
  std::uint64_t queries = 0, tasks = 0, peak = 0;

  double whole(double pixel_factor) const { return photons + rest * pixel_factor; }
};

Run run(const Set& set, const RenderSettings& settings) {
  Job job(set.scene, set.tracer, settings);
  job.wait();
  const Statistics& s = job.statistics();
  Run r;
  r.photons = s.seconds(Phase::trace_photons) + s.seconds(Phase::build_photon_map);
  r.rest = s.seconds(Phase::total) - r.photons;
  r.look_up = s.seconds(Phase::reorder) + s.seconds(Phase::density);
  r.queries = s.count(Counter::query_points);
  r.k = static_cast<double>(s.count(Counter::shader_operations)) /
        static_cast<double>(std::max<std::uint64_t>(r.queries, 1));
  r.tasks = job.tasks();
  r.peak = job.peak_beside_scene_bytes();
  return r;
}

/// Seconds of normal and reverse photon mapping in Table 1 of the paper.
struct Published {
  const char* scene;
  int side;
  double normal, reverse;
};
constexpr Published kPublished[] = {
    {"cornell", 300, 605, 420}, {"cornell", 500, 1540, 710}, {"sponza", 300, 840, 493}, {"sponza", 500, 2613, 1280}};

/// Table 1: whole renders.
void table_render(bool full, const std::set<std::string>& parts) {
  const int part = full ? 1 : 5;
  Table table("hhs05_render", "Whole renders, 600 gather rays of each pixel ([HHS05], Table 1)",
              {"scene", "pixels", "measured at", "normal, s", "reverse, s", "blocked, s", "k normal", "k reverse",
               "reverse over normal", "blocked over normal", "looking up: reverse over normal", "rays alone, s",
               "published normal, s", "published reverse, s", "published speed-up"});
  const bool chosen =
      std::any_of(parts.begin(), parts.end(), [](const std::string& p) { return p.starts_with("scene:"); });
  for (const std::string& path : scene_paths()) {
    const std::string name = short_name(path);
    if (chosen && parts.count("scene:" + name) == 0) continue;
    const Set set(path);
    for (const int side : {300, 500}) {
      const int measured = side / part;
      const double factor = static_cast<double>(part) * part;
      const Run normal = run(set, paper_settings("knn", measured)),
                reverse = run(set, paper_settings("reverse", measured)),
                blocked = run(set, paper_settings("blocked", measured));
      std::vector<Cell> row = {name,
                               fmt::format("{0}x{0}", side),
                               fmt::format("{0}x{0}", measured),
                               Number{normal.whole(factor)},
                               Number{reverse.whole(factor)},
                               Number{blocked.whole(factor)},
                               Number{normal.k},
                               Number{reverse.k},
                               Number{normal.whole(factor) / reverse.whole(factor)},
                               Number{normal.whole(factor) / blocked.whole(factor)},
                               Number{normal.look_up / reverse.look_up},
                               Number{(reverse.rest - reverse.look_up) * factor}};
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
  table.note("Rays alone: what reverse takes beside photon pass and looking up, which no engine takes less than.");
  if (!full)
    table.note(
        "Measured on 1/25 of the pixels; what grows with the pixels is multiplied by 25, the photon pass is not.");
  table.write();
}

/// Table 2: memory against tasks and time.
void table_memory() {
  Table table("hhs05_memory", "Time over memory, atrium, 283x283 pixels, 100 gather rays each ([HHS05], Table 2)",
              {"engine", "memory, MB", "on disk", "tasks", "held beside the scene, MB", "time, s",
               "over that of the most memory"});
  const Set set("builtin:atrium");
  keep_heap_small();  // as the program does with a small budget; else one render would leave its memory to the next
  for (const char* engine : {"reverse", "blocked"}) {
    double most = 0;
    struct Memory {
      std::uint64_t megabytes;
      DiskUse disk;
    };
    for (const auto& [megabytes, disk] : {Memory{4000, DiskUse::never},
                                          {2000, DiskUse::never},
                                          {1000, DiskUse::never},
                                          {400, DiskUse::never},
                                          {200, DiskUse::never},
                                          {400, DiskUse::always},
                                          {200, DiskUse::always}}) {
      RenderSettings settings = paper_settings(engine, 283);
      settings.samples = 1;
      settings.gather = 100;
      settings.photons = 200'000;
      settings.memory_bytes = megabytes * 1'000'000;
      settings.disk = disk;
      const Run r = run(set, settings);
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
              {"engine", "photons", "photon pass, s", "at 150x150: rays and look-up, s", "look-up, s", "k",
               "whole at 500x500, s", "over that of the fewest"});
  const Set set("builtin:atrium");
  constexpr int kSide = 150;
  for (const char* engine : {"reverse", "blocked"}) {
    double fewest = 0;
    for (const std::uint64_t photons : {100'000, 200'000, 500'000, 1'000'000}) {
      RenderSettings settings = paper_settings(engine, kSide);
      settings.photons = photons;
      const Run r = run(set, settings);
      const double whole = r.whole(500.0 * 500 / (kSide * kSide));
      if (fewest == 0) fewest = whole;
      table.add({engine, Number{static_cast<double>(photons), 7}, Number{r.photons}, Number{r.rest}, Number{r.look_up},
                 Number{r.k}, Number{whole}, Number{whole / fewest}});
    }
  }
  table.note("Radii for k = 50 whatever the number. The whole at 500x500 is reckoned: pixels times 11.1.");
  table.write();
}

/// Shares of time by phase.
void table_phases() {
  constexpr Phase kPhases[] = {Phase::trace_photons, Phase::build_photon_map, Phase::camera_pass, Phase::gather_rays,
                               Phase::reorder,       Phase::density,          Phase::completion};
  std::vector<std::string> columns = {"engine", "time, s"};
  for (const Phase phase : kPhases) columns.push_back(fmt::format("{}, %", name(phase)));
  Table table("hhs05_phases", "Share of time by phase, atrium, 100x100 pixels, 600 gather rays each", columns);
  const Set set("builtin:atrium");
  for (const char* engine : {"knn", "reverse", "blocked", "forward"}) {
    Job job(set.scene, set.tracer, paper_settings(engine, 100));
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

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// The grey box against its reference.
void table_grey() {
  const std::string folder = shared_folder();
  const std::string reference = folder + "/references/cornell-grey.exr";
  if (!std::filesystem::exists(reference)) return;
  Table table("grey_box", "Grey Cornell box, 128x128 pixels, all light, against its reference of 4096 samples",
              {"samples", "gather rays each", "photons", "k", "relRMSE", "processor, s"});
  const Image truth = read_image(reference);
  struct Effort {
    std::uint32_t samples, gather;
    std::uint64_t photons;
    std::uint32_t nearest;
  };
  for (const Effort& e : {Effort{16, 25, 100'000, 50},
                          {64, 4, 100'000, 60},
                          {64, 4, 100'000, 100},
                          {64, 6, 100'000, 100},
                          {64, 16, 300'000, 100}}) {
    const double start = processor_seconds();
    const Set set(folder + "/scenes/cornell-grey-pbrt/cornell-grey-reference.pbrt");
    RenderSettings settings;
    settings.width = settings.height = 128;
    settings.samples = e.samples;
    settings.gather = e.gather;
    settings.photons = e.photons;
    settings.nearest = e.nearest;
    settings.separate_layers = false;
    Job job(set.scene, set.tracer, settings);
    job.wait();
    const Image image = make_image(job.snapshot(), job);
    const double seconds = processor_seconds() - start;
    table.add({Number{double(e.samples)}, Number{double(e.gather)}, Number{double(e.photons), 7},
               Number{double(e.nearest)}, Number{compare_images(image, truth).relative_rmse}, Number{seconds}});
  }
  table.note(
      "Published for pbrt-v4 on such a machine: SPPM 153 s to 0.022, bidirectional 82 s to 0.033, path tracing 32 s "
      "to 0.047. The reference's own noise is about 0.011.");
  table.write();
}

/// The large render, by one of its samples.
void table_atrium() {
  Table table("atrium_2mp", "Atrium, 1920x1080 pixels, 600 gather rays each, within 4 GB",
              {"engine", "photon pass, s", "a sample of 24, s", "whole, min", "held beside the scene, MB"});
  const Set set("builtin:atrium");
  for (const char* engine : {"reverse", "blocked"}) {
    RenderSettings settings = paper_settings(engine, 1080);
    settings.width = 1920;
    settings.samples = 1;
    settings.memory_bytes = 4'000'000'000;
    const Run r = run(set, settings);
    table.add({engine, Number{r.photons}, Number{r.rest}, Number{r.whole(kSamples) / 60},
               Number{static_cast<double>(r.peak) / 1e6}});
  }
  table.note(
      "One camera sample of each pixel with its 25 gather rays was rendered; the whole is reckoned: photon pass and "
      "24 such. 500,000 photons. Published for Sponza with 600: 160 minutes.");
  table.write();
}

void write_tables(const std::set<std::string>& parts) {
  const auto wanted = [&](const char* part) { return parts.empty() || parts.count(part) > 0; };
  const bool full = parts.count("full") > 0;
  if (wanted("grey")) table_grey();
  if (wanted("atrium")) table_atrium();
  if (wanted("phases")) table_phases();
  if (wanted("photons")) table_photons();
  if (wanted("render") || full) table_render(full, parts);
  if (wanted("memory")) table_memory();
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  try {
    glowworm::bench::write_tables({argv + 1, argv + argc});
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "tables_reverse: {}\n", error.what());
    return 1;
  }
}
