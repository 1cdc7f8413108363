// Rays per second of one thread: camera rays and final gather rays, by their order and by how they are handed to the
// tracer. Writes bench/results/rays.md.
//
//   ray_bench [SIDE [REPEATS]]     SIDE: pixels of the square tile of a 320x320 picture whose rays are traced
//   ray_bench count [SIDE]         traces each order once, for scripts/count-instructions rays
//   ray_bench camera FILE [SIDE]   writes the atrium's camera rays to a file, and prints how many of them a second
//                                  it traces one by one and in one batch: for bench/tables_measure.py
//
// Times are processor time of the thread, so that other work on the machine disturbs them little; medians of repeats.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
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
#include "support/table.h"

namespace glowworm::bench {
namespace {

constexpr int kPicture = 320;
constexpr std::uint32_t kRaysEach = 64;
constexpr std::size_t kPointsPerChunk = 512;

/// Median over repeats of the processor time of work().
double median_seconds(int repeats, const std::function<void()>& work) {
  const auto seconds_now = [] {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  };
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const double start = seconds_now();
    work();
    times.push_back(seconds_now() - start);
  }
  return spread_of(std::move(times)).median;
}

/// Rays sorted by cell of the origin along the Hilbert curve, then by octant of the direction, then by place in the
/// cell.
std::vector<Ray> fully_sorted(const std::vector<Ray>& rays, const Box3& bounds) {
  const CubeGrid grid(bounds, 7);
  std::vector<KeyedIndex<std::uint64_t>> keys(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::uint64_t place = hilbert_key_of_morton(grid.morton(rays[i].origin), 7);
    const Vec3 d = rays[i].direction;
    const std::uint64_t octant = std::uint64_t{d.x < 0} << 2 | std::uint64_t{d.y < 0} << 1 | std::uint64_t{d.z < 0};
    keys[i] = {(place >> 12) << 15 | octant << 12 | (place & 4095), static_cast<std::uint32_t>(i)};
  }
  radix_sort(keys, 24);
  std::vector<Ray> out(rays.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = rays[keys[i].index];
  return out;
}

/// Rays of a scene in one order.
struct Order {
  const char* name;
  std::vector<Ray> rays;
  RayOrder told;        ///< what the tracer is told of them
  double sort_seconds;  ///< for making the order
};

/// What is traced of a scene.
class SceneBench {
 public:
  /// @param gather rays of final gathering, too
  SceneBench(const char* name, int side, int repeats, bool gather = true)
      : name_(name), repeats_(repeats), scene_(builtin_scene(name)), tracer_(scene_) {
    CameraTask task;
    task.x0 = task.y0 = (kPicture - side) / 2;
    task.x1 = task.y1 = task.x0 + side;
    CameraPassSettings settings;
    settings.width = settings.height = kPicture;
    SlotRadiance radiance;
    FirstHit first_hit;
    Statistics statistics;
    points_ = camera_pass(tracer_, scene_.camera(""), task, settings, radiance, first_hit, statistics);
    std::vector<Ray> camera_rays;
    for (int y = task.y0; y < task.y1; ++y)
      for (int x = task.x0; x < task.x1; ++x) {
        const Vec2 at{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
        const CameraRay ray = generate_ray(scene_.camera(""), at, kPicture, kPicture, {0.5f, 0.5f});
        camera_rays.push_back({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
      }
    orders_.push_back({"camera, scan lines", std::move(camera_rays), RayOrder::camera, 0});
    if (gather) make_gather_orders();
  }

  /// Adds rows for all orders, and one for the whole of final_gather().
  void measure(Table& table) {
    for (const Order& order : orders_) {
      std::vector<Hit> hits(order.rays.size());
      const auto add = [&](const char* way, double seconds) {
        seconds += order.sort_seconds;
        table.add({name_, order.name, way, Number{1e-6 * static_cast<double>(order.rays.size()) / seconds},
                   Number{100 * order.sort_seconds / seconds}});
      };
      add("one by one", median_seconds(repeats_, [&] {
            for (std::size_t i = 0; i < order.rays.size(); ++i) hits[i] = tracer_.intersect(order.rays[i]);
          }));
      add("batch", median_seconds(repeats_, [&] { tracer_.intersect(order.rays, hits, order.told); }));
    }
    FinalGatherSettings settings;
    settings.rays = kRaysEach;
    SlotRadiance radiance;
    radiance.resize(static_cast<std::size_t>(kPicture) * kPicture);
    Statistics statistics;
    QueryPoints queries;
    const double seconds = median_seconds(repeats_, [&] {
      final_gather(tracer_, points_, 0, points_.size(), settings, radiance, {queries}, statistics);
    });
    const double rays = static_cast<double>(points_.size()) * kRaysEach;
    table.add({name_, "gather, whole phase", "final_gather()", Number{1e-6 * rays / seconds}, {}});
  }

  /// Writes the camera rays as binary floats: origin and direction of each.
  void write_camera_rays(const std::string& path) const {
    std::ofstream file(path, std::ios::binary);
    for (const Ray& ray : orders_[0].rays) {
      const float numbers[6] = {ray.origin.x,    ray.origin.y,    ray.origin.z,
                                ray.direction.x, ray.direction.y, ray.direction.z};
      file.write(reinterpret_cast<const char*>(numbers), sizeof(numbers));
    }
  }

  /// Camera rays that are traced one by one, and in one batch, in a second.
  void print_camera_rates() const {
    const std::vector<Ray>& rays = orders_[0].rays;
    std::vector<Hit> hits(rays.size());
    const auto count = static_cast<double>(rays.size());
    const double single = median_seconds(repeats_, [&] {
      for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = tracer_.intersect(rays[i]);
    });
    const double batch = median_seconds(repeats_, [&] { tracer_.intersect(rays, hits, orders_[0].told); });
    fmt::print("{} {}\n", count / single, count / batch);
  }

  /// Traces orders once each, in functions of their own by which callgrind tells them apart; prints their rays.
  void count() const {
    counted<0>(orders_[1], false);
    counted<1>(orders_[1], true);
    counted<2>(orders_[2], false);
    counted<3>(orders_[2], true);
    counted<4>(orders_[3], true);
    counted<5>(orders_[0], false);
    counted<6>(orders_[0], true);
  }

 private:
  template <int kCase>
  [[gnu::noinline]] void counted(const Order& order, bool batch) const {
    std::vector<Hit> hits(order.rays.size());
    if (batch)
      tracer_.intersect(order.rays, hits, order.told);
    else
      for (std::size_t i = 0; i < order.rays.size(); ++i) hits[i] = tracer_.intersect(order.rays[i]);
    fmt::print("{};{};{}, {}\n", kCase, order.rays.size(), order.name, batch ? "batch" : "one by one");
  }

  /// Gather rays point by point, in the order of final_gather(), and sorted.
  void make_gather_orders() {
    GatherPaths rays;
    GatherRayMaker maker;
    std::vector<std::uint32_t> order(points_.size());
    std::iota(order.begin(), order.end(), 0u);
    maker.prepare(points_, order, kRaysEach, 0, nullptr);
    maker.create(0, kRaysEach, rays);
    std::stable_sort(rays.begin(), rays.end(),
                     [](const GatherPath& a, const GatherPath& b) { return a.point < b.point; });
    std::vector<Ray> created;
    for (const GatherPath& path : rays) created.push_back(path.ray);
    std::vector<Ray> framed;
    const auto for_chunks = [&](const std::function<void()>& work) {
      for (std::size_t first = 0; first < points_.size(); first += kPointsPerChunk) {
        coherent_order(points_, first, std::min(first + kPointsPerChunk, points_.size()), order);
        work();
      }
    };
    for_chunks([&] {
      rays.clear();
      maker.prepare(points_, order, kRaysEach, 0, nullptr);
      maker.create(0, kRaysEach, rays);
      for (const GatherPath& path : rays) framed.push_back(path.ray);
    });
    const double framed_seconds = median_seconds(repeats_, [&] { for_chunks([] {}); });
    std::vector<Ray> sorted;
    const double sort_seconds = median_seconds(repeats_, [&] { sorted = fully_sorted(created, scene_.bounds()); });
    orders_.push_back({"gather, point by point", std::move(created), RayOrder::incoherent, 0});
    orders_.push_back({"gather, strata by frame", std::move(framed), RayOrder::incoherent, framed_seconds});
    orders_.push_back({"gather, all sorted", std::move(sorted), RayOrder::incoherent, sort_seconds});
  }

  const char* name_;
  int repeats_;
  Scene scene_;
  Tracer tracer_;
  GatherPoints points_;
  std::vector<Order> orders_;
};

int run(int argc, char** argv) {
  set_thread_count(1);
  if (argc > 1 && std::string(argv[1]) == "count") {
    SceneBench("atrium", argc > 2 ? std::clamp(std::atoi(argv[2]), 1, kPicture) : 24, 1).count();
    return 0;
  }
  if (argc > 2 && std::string(argv[1]) == "camera") {
    const SceneBench atrium("atrium", argc > 3 ? std::clamp(std::atoi(argv[3]), 1, kPicture) : kPicture, 15, false);
    atrium.write_camera_rays(argv[2]);
    atrium.print_camera_rates();
    return 0;
  }
  const int side = argc > 1 ? std::atoi(argv[1]) : 160, repeats = argc > 2 ? std::atoi(argv[2]) : 5;
  if (side < 1 || side > kPicture || repeats < 1) {
    fmt::print(stderr, "usage: ray_bench [SIDE (1 to {}) [REPEATS]]\n", kPicture);
    return 1;
  }
  Table table("rays", fmt::format("Rays of a tile of {0}x{0} pixels, {1} final gather rays a point", side, kRaysEach),
              {"scene", "rays", "way", "million rays/s", "ordering, % of the time"});
  for (const char* name : {"atrium", "atrium-large"}) SceneBench(name, side, repeats).measure(table);
  table.note("Processor time of one thread, ordering included.");
  table.write();
  return 0;
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) { return glowworm::bench::run(argc, argv); }
