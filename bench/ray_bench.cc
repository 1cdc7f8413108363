// Rays per second of one thread: camera rays and final gather rays, by their order, by how they are handed to Embree
// and by Embree's settings; then what the phases around them cost. Writes bench/results/rays.md and rays.csv.
//
//   ray_bench [SIDE [REPEATS]]     SIDE: pixels of the square tile of a 320x320 picture whose rays are traced
//   ray_bench count [SIDE]         traces some of the orders once, for scripts/count-instructions rays
//
// Times are processor time of the thread, so that other work on the machine disturbs them little; medians of repeats.
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "builtin/builtin.h"
#include "core/hilbert.h"
#include "core/parallel.h"
#include "core/radix_sort.h"
#include "gather/camera_pass.h"
#include "gather/final_gather.h"
#include "gather/gather_rays.h"
#include "photon/photon_tracer.h"
#include "support/embree_scene.h"

namespace glowworm::bench {
namespace {

constexpr int kPicture = 320;
constexpr std::uint32_t kRaysEach = 64;
constexpr std::size_t kPointsPerChunk = 512;

double seconds_of(clockid_t clock) {
  timespec now;
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Median over repeats of the processor time of work().
double median_seconds(int repeats, const std::function<void()>& work, clockid_t clock = CLOCK_THREAD_CPUTIME_ID) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const double start = seconds_of(clock);
    work();
    times.push_back(seconds_of(clock) - start);
  }
  std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
  return times[static_cast<std::size_t>(repeats) / 2];
}

/// Cell of a direction in a 32 x 32 grid over the octahedron.
std::uint32_t direction_cell(Vec3 d) {
  const float scale = 1 / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  float x = d.x * scale, y = d.y * scale;
  if (d.z < 0) {
    const float folded = (1 - std::abs(y)) * std::copysign(1.0f, x);
    y = (1 - std::abs(x)) * std::copysign(1.0f, y);
    x = folded;
  }
  const auto along = [](float v) { return static_cast<std::uint32_t>(std::clamp((v + 1) * 16, 0.0f, 31.0f)); };
  return along(y) << 5 | along(x);
}

/// All rays sorted by 3-bit Hilbert cell of the origin, then direction cell, then place of the origin in its cell.
std::vector<Ray> fully_sorted(const std::vector<Ray>& rays, const Box3& bounds) {
  const CubeGrid grid(bounds, 7);
  std::vector<KeyedIndex<std::uint64_t>> keys(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::uint64_t place = hilbert_key_of_morton(grid.morton(rays[i].origin), 7);
    keys[i] = {(place >> 12) << 22 | std::uint64_t{direction_cell(rays[i].direction)} << 12 | (place & 4095),
               static_cast<std::uint32_t>(i)};
  }
  radix_sort(keys, 31);
  std::vector<Ray> out(rays.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = rays[keys[i].index];
  return out;
}

/// One line of the tables.
struct Row {
  std::string scene, rays, config, order, way;
  double rate, sort_share;  ///< million rays a second with the sort; sort over all
};

struct Report {
  std::vector<Row> rows;
  std::string phases;
  void add(Row row) {
    fmt::print("{:13} {:7} {:30} {:26} {:14} {:6.2f}\n", row.scene, row.rays, row.config, row.order, row.way, row.rate);
    std::fflush(stdout);
    rows.push_back(std::move(row));
  }
};

struct Order {
  const char* name;
  std::vector<Ray> rays;
  double sort_seconds;
};

/// What is traced of a scene.
class SceneBench {
 public:
  SceneBench(const char* name, int side, int repeats, Report& report)
      : name_(name), repeats_(repeats), report_(report), scene_(builtin_scene(name)), tracer_(scene_) {
    CameraTask task;
    task.x0 = task.y0 = (kPicture - side) / 2;
    task.x1 = task.y1 = task.x0 + side;
    CameraPassSettings settings;
    settings.width = settings.height = kPicture;
    SlotRadiance radiance;
    FirstHit first_hit;
    Statistics statistics;
    points_ = camera_pass(tracer_, scene_.camera(""), task, settings, radiance, first_hit, statistics);
    for (int y = task.y0; y < task.y1; ++y)
      for (int x = task.x0; x < task.x1; ++x) {
        const Vec2 at{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
        const CameraRay ray = generate_ray(scene_.camera(""), at, kPicture, kPicture, {0.5f, 0.5f});
        camera_rays_.push_back({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
      }
    make_orders();
  }

  void run() {
    in_turns();
    const auto plain = RTC_SCENE_FLAG_NONE;
    const auto medium = RTC_BUILD_QUALITY_MEDIUM;
    {
      const EmbreeScene embree(scene_, nullptr, medium, plain);
      for (const bool coherent : {false, true})
        for (const Way way : kWays)
          measure(embree, coherent ? "default, coherent flag" : "default", {"scan lines", camera_rays_, 0}, "camera",
                  way, coherent);
      for (const Order& order : orders_)
        for (const Way way : kWays) measure(embree, "default", order, "gather", way, false);
      measure(embree, "default, coherent flag", orders_[kKept], "gather", Way::packet8, true);
      measure(embree, "default", again_, "gather", Way::single, false);
    }
    const struct {
      const char *name, *config;
      RTCBuildQuality quality;
      RTCSceneFlags flags;
    } configs[] = {
        {"frequency_level=simd128", "frequency_level=simd128", medium, plain},
        {"frequency_level=simd256", "frequency_level=simd256", medium, plain},
        {"tri_accel=bvh4.triangle4", "tri_accel=bvh4.triangle4", medium, plain},
        {"tri_accel=bvh8.triangle4", "tri_accel=bvh8.triangle4", medium, plain},
        {"tri_accel=bvh8.triangle4v", "tri_accel=bvh8.triangle4v", medium, plain},
        {"hugepages=0", "hugepages=0", medium, plain},
        {"build quality low", nullptr, RTC_BUILD_QUALITY_LOW, plain},
        {"build quality high", nullptr, RTC_BUILD_QUALITY_HIGH, plain},
        {"compact", nullptr, medium, RTC_SCENE_FLAG_COMPACT},
        {"robust", nullptr, medium, RTC_SCENE_FLAG_ROBUST},
    };
    for (const auto& c : configs) {
      const EmbreeScene embree(scene_, c.config, c.quality, c.flags);
      if (!embree.usable()) continue;
      measure(embree, c.name, orders_[0], "gather", Way::single, false);
      measure(embree, c.name, orders_[kKept], "gather", Way::single, false);
      measure(embree, c.name, orders_[kKept], "gather", Way::packet8, false);
      if (c.quality == RTC_BUILD_QUALITY_HIGH) measure(embree, c.name, again_, "gather", Way::single, false);
    }
    phases();
  }

  /// What the renderer does and what might be better, one after the other in each of several rounds, since the
  /// machine's speed changes within minutes.
  void in_turns() {
    const auto plain = RTC_SCENE_FLAG_NONE;
    const auto high = RTC_BUILD_QUALITY_HIGH;
    const EmbreeScene usual(scene_, nullptr, RTC_BUILD_QUALITY_MEDIUM, plain), split(scene_, nullptr, high, plain),
        quads(scene_, nullptr, high, plain, true), twice(scene_, "max_spatial_split_replications=2", high, plain);
    const struct {
      const char* config;
      const EmbreeScene& embree;
      const Order& order;
      Way way;
    } ways[] = {
        {"in turns: default", usual, orders_[0], Way::single},
        {"in turns: default", usual, orders_[kKept], Way::packet8},
        {"in turns: high", split, orders_[0], Way::single},
        {"in turns: high", split, orders_[kKept], Way::packet8},
        {"in turns: high, quads", quads, orders_[kKept], Way::packet8},
        {"in turns: high, twice the triangles", twice, orders_[kKept], Way::packet8},
        {"in turns: default", usual, again_, Way::single},
        {"in turns: high", split, again_, Way::single},
    };
    std::vector<std::vector<double>> seconds(std::size(ways));
    std::size_t most = 0;
    for (const auto& way : ways) most = std::max(most, way.order.rays.size());
    std::vector<Hit> hits(most);
    for (int round = 0; round < 2 * repeats_ + 1; ++round)
      for (std::size_t w = 0; w < std::size(ways); ++w)
        seconds[w].push_back(
            median_seconds(1, [&] { ways[w].embree.trace(ways[w].order.rays, hits, ways[w].way, false); }));
    for (std::size_t w = 0; w < std::size(ways); ++w) {
      auto& times = seconds[w];
      std::nth_element(times.begin(), times.begin() + repeats_, times.end());
      const double all = ways[w].order.sort_seconds + times[static_cast<std::size_t>(repeats_)];
      report_.add({name_, "gather", ways[w].config, ways[w].order.name, name(ways[w].way),
                   static_cast<double>(ways[w].order.rays.size()) / all * 1e-6, ways[w].order.sort_seconds / all});
    }
  }

  /// Traces orders once each, in functions of their own by which callgrind tells them apart; prints their rays.
  void count() const {
    const EmbreeScene medium(scene_, nullptr, RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_NONE),
        high(scene_, nullptr, RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
    const std::vector<Ray>&created = orders_[0].rays, &framed = orders_[kKept].rays, &sorted = orders_[3].rays;
    counted<0>(medium, created, Way::single, false, "as created, single");
    counted<1>(medium, framed, Way::single, false, "strata by frame, single");
    counted<2>(medium, framed, Way::packet8, false, "strata by frame, packets of 8");
    counted<3>(medium, sorted, Way::packet8, false, "all sorted, packets of 8");
    counted<4>(medium, framed, Way::packet8, true, "strata by frame, packets of 8, coherent flag");
    counted<5>(high, created, Way::single, false, "as created, single, high build quality");
    counted<6>(high, framed, Way::packet8, false, "strata by frame, packets of 8, high build quality");
    counted<7>(medium, camera_rays_, Way::single, false, "camera rays, single");
    counted<8>(medium, camera_rays_, Way::packet8, false, "camera rays, packets of 8");
    counted<9>(medium, camera_rays_, Way::packet8, true, "camera rays, packets of 8, coherent flag");
    const EmbreeScene quads(scene_, nullptr, RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE, true),
        split(scene_, "max_spatial_split_replications=2", RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
    counted<10>(quads, framed, Way::packet8, false, "strata by frame, packets of 8, quads, high");
    counted<11>(split, framed, Way::packet8, false, "strata by frame, packets of 8, high, twice the triangles");
  }

 private:
  static constexpr std::size_t kKept = 2;  ///< the order that final_gather() uses

  template <int kCase>
  [[gnu::noinline]] static void counted(const EmbreeScene& embree, const std::vector<Ray>& rays, Way way, bool coherent,
                                        const char* what) {
    std::vector<Hit> hits(rays.size());
    embree.trace(rays, hits, way, coherent);
    fmt::print("{};{};{}\n", kCase, rays.size(), what);
  }

  void make_orders() {
    GatherRays rays;
    std::vector<std::uint32_t> all(points_.size());
    std::iota(all.begin(), all.end(), 0u);
    GatherRayMaker maker;
    maker.prepare(points_, all, kRaysEach, 0);
    maker.create(0, kRaysEach, rays);
    std::vector<std::uint32_t> by_point(rays.size());
    std::iota(by_point.begin(), by_point.end(), 0u);
    std::stable_sort(by_point.begin(), by_point.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return rays.point[a] < rays.point[b]; });
    std::vector<Ray> created;
    for (const std::uint32_t i : by_point) created.push_back(rays.rays[i]);

    std::vector<Ray> chunks;
    for (std::size_t first = 0; first < points_.size(); first += kPointsPerChunk) {
      rays.clear();
      const std::size_t n = std::min(kPointsPerChunk, points_.size() - first);
      maker.prepare(points_, std::span(all).subspan(first, n), kRaysEach, 0);
      maker.create(0, kRaysEach, rays);
      chunks.insert(chunks.end(), rays.rays.begin(), rays.rays.end());
    }
    std::vector<Ray> framed;
    std::vector<std::uint32_t> order;
    for (std::size_t first = 0; first < points_.size(); first += kPointsPerChunk) {
      rays.clear();
      coherent_order(points_, first, std::min(first + kPointsPerChunk, points_.size()), order);
      maker.prepare(points_, order, kRaysEach, 0);
      maker.create(0, kRaysEach, rays);
      framed.insert(framed.end(), rays.rays.begin(), rays.rays.end());
    }
    const double framed_seconds = median_seconds(repeats_, [&] {
      for (std::size_t first = 0; first < points_.size(); first += kPointsPerChunk)
        coherent_order(points_, first, std::min(first + kPointsPerChunk, points_.size()), order);
    });
    std::vector<Ray> sorted;
    const double sort_seconds = median_seconds(repeats_, [&] { sorted = fully_sorted(created, scene_.bounds()); });
    // What no order can surpass: whatever a ray needs, the ray before it has just needed.
    again_.name = "each ray eight times";
    for (std::size_t i = 0; i < created.size(); i += 8) again_.rays.insert(again_.rays.end(), 8, created[i]);
    orders_ = {{"as created", std::move(created), 0},
               {"strata of 512 points", std::move(chunks), 0},
               {"strata, by frame", std::move(framed), framed_seconds},
               {"all sorted", std::move(sorted), sort_seconds}};
  }

  void measure(const EmbreeScene& embree, const char* config, const Order& order, const char* kind, Way way,
               bool coherent) {
    std::vector<Hit> hits(order.rays.size());
    const double seconds =
        order.sort_seconds + median_seconds(repeats_, [&] { embree.trace(order.rays, hits, way, coherent); });
    report_.add({name_, kind, config, order.name, name(way), static_cast<double>(order.rays.size()) / seconds * 1e-6,
                 order.sort_seconds / seconds});
  }

  /// What the whole phases cost beside tracing alone.
  void phases() {
    const std::vector<Ray>& rays = orders_[kKept].rays;
    std::vector<Hit> hits(rays.size());
    const double tracing = median_seconds(repeats_, [&] { tracer_.intersect(rays, hits, RayOrder::incoherent); });
    FinalGatherSettings settings;
    settings.rays = kRaysEach;
    SlotRadiance radiance;
    radiance.resize(static_cast<std::size_t>(kPicture) * kPicture);
    Statistics statistics;
    QueryPoints queries;
    const double gathering = median_seconds(
        repeats_, [&] { final_gather(tracer_, points_, 0, points_.size(), settings, radiance, queries, statistics); });
    PhotonPassSettings photons;
    PhotonPass pass;
    const double photon_cpu = median_seconds(repeats_, [&] { pass = trace_photons(tracer_, photons, statistics); });
    const double n = static_cast<double>(rays.size());
    report_.phases += fmt::format("| {} | {:.0f} | {:.0f} | {:.2f} | {} | {:.3f} |\n", name_, tracing / n * 1e9,
                                  gathering / n * 1e9, gathering / tracing, pass.global.size(), photon_cpu);
  }

  const char* name_;
  int repeats_;
  Report& report_;
  Scene scene_;
  Tracer tracer_;
  GatherPoints points_;
  std::vector<Ray> camera_rays_;
  std::vector<Order> orders_;
  Order again_{};
};

std::string markdown(const Report& report, int side, int repeats) {
  std::string out = fmt::format(
      "# Rays per second\n\n`ray_bench {} {}`: tile of {}x{} pixels of a {}x{} picture, {} final gather rays a point; "
      "million rays/s of one thread by its processor time, sorting included; medians of {} runs.\n\n"
      "| scene | rays | Embree | order | way | million rays/s | over default single, as created | sort's share |\n"
      "| --- | --- | --- | --- | --- | ---: | ---: | ---: |\n",
      side, repeats, side, side, kPicture, kPicture, kRaysEach, repeats);
  for (const Row& row : report.rows) {
    const auto base = std::find_if(report.rows.begin(), report.rows.end(), [&](const Row& r) {
      return r.scene == row.scene && r.rays == row.rays && r.config == "default" && r.way == "single";
    });
    out += fmt::format("| {} | {} | {} | {} | {} | {:.2f} | {:.2f} | {:.1f}% |\n", row.scene, row.rays, row.config,
                       row.order, row.way, row.rate, row.rate / base->rate, 100 * row.sort_share);
  }
  out +=
      "\n## Phases, one thread\n\n"
      "| scene | tracing, ns/ray | final gather, ns/ray | ratio | photons | photon pass, s |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: |\n" +
      report.phases;
  return out;
}

std::string csv(const Report& report) {
  std::string out = "scene,rays,embree,order,way,million_rays_per_s,sort_share\n";
  for (const Row& row : report.rows)
    out += fmt::format("{},{},\"{}\",\"{}\",{},{:.4f},{:.5f}\n", row.scene, row.rays, row.config, row.order, row.way,
                       row.rate, row.sort_share);
  return out;
}

int run(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "count") {
    set_thread_count(1);
    Report report;
    SceneBench("atrium", argc > 2 ? std::clamp(std::atoi(argv[2]), 1, kPicture) : 24, 1, report).count();
    return 0;
  }
  const int side = argc > 1 ? std::atoi(argv[1]) : 160, repeats = argc > 2 ? std::atoi(argv[2]) : 5;
  if (side < 1 || side > kPicture || repeats < 1) {
    fmt::print(stderr, "usage: ray_bench [SIDE (1 to {}) [REPEATS]]\n", kPicture);
    return 1;
  }
  set_thread_count(1);
  Report report;
  for (const char* name : {"atrium", "atrium-large"}) SceneBench(name, side, repeats, report).run();
  const std::string table = markdown(report, side, repeats);
  fmt::print("\n{}", table);
  std::filesystem::create_directories("bench/results");
  std::ofstream("bench/results/rays.md") << table;
  std::ofstream("bench/results/rays.csv") << csv(report);
  return 0;
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) { return glowworm::bench::run(argc, argv); }
