// Photons: how fast they are traced, and their maps built and searched, beside nanoflann on the same points in the same
// order.
// --scene=SCENE takes photons and query points recorded in a scene (default: builtin:atrium). --photons=N,
// --side=PIXELS and --rays=N say how many of them. --guided takes them guided, as renders do. --simd=NAME is that of
// `glowworm render`. Those of a large render:
//   density_bench --guided --photons=2000000 --side=320 --rays=100 --benchmark_filter=estimate/blocked/per_photon
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/parallel.h"
#include "density/engine.h"
#include "density/kd_tree.h"
#include "density/knn.h"
#include "density/radius.h"
#include "density/reorder.h"
#include "glowworm/density.h"
#include "kernels/simd.h"
#include "photon/photon_tracer.h"
#include "support/nanoflann_tree.h"
#include "support/recording.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

constexpr std::uint32_t kNearest = 45;

std::string scene_name = "builtin:atrium";
RecordingSettings recorded{500'000, 80, 80, 313, false};

const Stage& stage() {
  static const Stage made(scene_name);
  return made;
}

/// Photons and query points, made once; the query points also along the Hilbert curve.
struct Cloud {
  PhotonBatch photons;
  QueryPoints points;
  std::vector<std::uint32_t> order;
  std::vector<float> radii;
  float radius;
  NanoflannPoints photon_points;
  std::unique_ptr<NanoflannTree> nanoflann;
  PhotonMap map;

  Cloud() {
    Recording recording = record(stage(), recorded);
    radius = fixed_radius_for(recording, kNearest).radius;
    photons = std::move(recording.photons);
    photon_points.positions = photons.position;
    points = std::move(recording.points);
    radii = per_photon_radii(photons, kNearest);
    ReorderSettings whole;
    whole.depth = 21;
    order = hilbert_order(points.position, bounds_of(points.position), photons.size(), whole);
    nanoflann = std::make_unique<NanoflannTree>(3, photon_points, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    map.build(photons, photons.flux, {});
  }
};
Cloud& cloud() {
  static Cloud made;
  return made;
}

void set_rate(benchmark::State& state, const char* name, double per_iteration) {
  state.counters[name] =
      benchmark::Counter(per_iteration, benchmark::Counter::kIsIterationInvariantRate, benchmark::Counter::kIs1000);
}

void nanoflann_nearest(benchmark::State& state) {
  const Cloud& c = cloud();
  std::vector<std::uint32_t> indices(kNearest);
  std::vector<float> distances(kNearest);
  for (auto _ : state) {
    for (const std::uint32_t i : c.order) {
      nanoflann::KNNResultSet<float, std::uint32_t> result(kNearest);
      result.init(indices.data(), distances.data());
      c.nanoflann->findNeighbors(result, &c.points.position[i].x, nanoflann::SearchParams());
      benchmark::DoNotOptimize(distances.back());
    }
  }
  set_rate(state, "queries", static_cast<double>(cloud().points.size()));
}

/// The same question: normals play no part.
void map_nearest(benchmark::State& state) {
  const Cloud& c = cloud();
  std::vector<std::uint64_t> heap(kNearest);
  std::uint64_t tested = 0;
  for (auto _ : state) {
    for (const std::uint32_t i : c.order) {
      benchmark::DoNotOptimize(c.map.nearest(c.points.position[i], c.points.normal[i], -2, kNearest,
                                             std::numeric_limits<float>::infinity(), heap, tested));
    }
  }
  set_rate(state, "queries", static_cast<double>(cloud().points.size()));
}

void nanoflann_radius(benchmark::State& state) {
  const Cloud& c = cloud();
  std::vector<std::pair<std::uint32_t, float>> found;
  nanoflann::SearchParams unsorted;
  unsorted.sorted = false;
  std::uint64_t pairs = 0;
  for (auto _ : state) {
    for (const std::uint32_t i : c.order) {
      pairs += c.nanoflann->radiusSearch(&c.points.position[i].x, c.radius * c.radius, found, unsorted);
    }
  }
  set_rate(state, "pairs", static_cast<double>(pairs) / static_cast<double>(state.iterations()));
}

void map_radius(benchmark::State& state) {
  const Cloud& c = cloud();
  std::vector<FoundPhoton> found;
  std::uint64_t pairs = 0, tested = 0;
  for (auto _ : state) {
    for (const std::uint32_t i : c.order) {
      c.map.within(c.points.position[i], c.points.normal[i], -2, c.radius, found, tested);
      pairs += found.size();
    }
  }
  set_rate(state, "pairs", static_cast<double>(pairs) / static_cast<double>(state.iterations()));
}

/// The public DensityIndex, which sums kernel times flux over the same pairs, on one thread.
void public_sum(benchmark::State& state, bool one_radius) {
  const Cloud& c = cloud();
  const auto outer = [](const auto& v) { return std::span(reinterpret_cast<const api::Vec3*>(v.data()), v.size()); };
  const std::span flux(reinterpret_cast<const api::Rgb*>(c.photons.flux.data()), c.photons.size());
  const api::PhotonArrays photons{outer(c.photons.position), flux, {}};
  const api::DensityIndex index =
      one_radius ? api::DensityIndex(photons, c.radius) : api::DensityIndex(photons, std::span(c.radii));
  std::uint64_t pairs = 0;
  Statistics statistics;
  // The pairs within the kernels, counted by the same engine.
  {
    RadiusPolicy policy;
    policy.min_normal_cosine = -2;
    if (one_radius)
      policy.radii.assign(c.photons.size(), c.radius);
    else
      policy.radii = c.radii;
    std::vector<RGB> found(c.points.size());
    const auto engine = make_engine(kAutomaticEngine);
    engine->build(c.photons, c.photons.flux, policy, statistics);
    engine->estimate(c.points, found, statistics);
    pairs = statistics.count(Counter::shader_operations);
  }
  set_thread_count(1);
  for (auto _ : state) benchmark::DoNotOptimize(index.sum(outer(c.points.position)).data());
  set_thread_count(0);
  set_rate(state, "pairs", static_cast<double>(pairs));
}

void nanoflann_build(benchmark::State& state) {
  const Cloud& c = cloud();
  for (auto _ : state) {
    NanoflannTree tree(3, c.photon_points, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    benchmark::DoNotOptimize(tree.root_node);
  }
  set_rate(state, "photons", static_cast<double>(cloud().photons.size()));
}

void tracing(benchmark::State& state) {
  const Tracer& tracer = *stage().tracer;
  set_thread_count(static_cast<int>(state.range(0)));
  PhotonPassSettings settings;
  settings.photons = recorded.photons;
  for (auto _ : state) {
    Statistics statistics;
    benchmark::DoNotOptimize(trace_photons(tracer, settings, statistics).global.size());
  }
  set_thread_count(0);
  set_rate(state, "photons", static_cast<double>(settings.photons));
}

void tree_build(benchmark::State& state) {
  const Cloud& c = cloud();
  set_thread_count(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(build_kd_tree(c.photons.position, 8).nodes.data());
  set_thread_count(0);
  set_rate(state, "photons", static_cast<double>(cloud().photons.size()));
}

void radii(benchmark::State& state) {
  const Cloud& c = cloud();
  set_thread_count(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(per_photon_radii(c.photons, kNearest).data());
  set_thread_count(0);
  set_rate(state, "photons", static_cast<double>(cloud().photons.size()));
}

/// Building the map of an engine, radii given.
void engine_build(benchmark::State& state, const std::string& name, const RadiusPolicy& policy) {
  const auto engine = make_engine(name);
  Statistics statistics;
  set_thread_count(static_cast<int>(state.range(0)));
  for (auto _ : state) engine->build(cloud().photons, cloud().photons.flux, policy, statistics);
  set_thread_count(0);
  set_rate(state, "photons", static_cast<double>(cloud().photons.size()));
}

/// A whole density phase of an engine, reordering included; query points in no order.
void engine_estimate(benchmark::State& state, const std::string& name, const RadiusPolicy& policy) {
  const Cloud& c = cloud();
  const auto engine = make_engine(name);
  Statistics statistics;
  engine->build(c.photons, c.photons.flux, policy, statistics);
  std::vector<RGB> radiance(c.points.size(), RGB(0.0f));
  set_thread_count(static_cast<int>(state.range(0)));
  for (auto _ : state) engine->estimate(c.points, radiance, statistics);
  set_thread_count(0);
  const double runs = static_cast<double>(state.iterations());
  set_rate(state, "queries", static_cast<double>(cloud().points.size()));
  set_rate(state, "operations", static_cast<double>(statistics.count(Counter::shader_operations)) / runs);
  set_rate(state, "pairs", static_cast<double>(statistics.count(Counter::pairs_tested)) / runs);
  state.counters["used"] = static_cast<double>(statistics.count(Counter::shader_operations)) /
                           static_cast<double>(statistics.count(Counter::pairs_tested));
  if (const auto steps = statistics.count(Counter::packet_steps)) {
    state.counters["lanes"] =
        static_cast<double>(statistics.count(Counter::packet_active_lanes)) / static_cast<double>(steps);
  }
  state.counters["reorder_share"] =
      statistics.seconds(Phase::reorder) / (statistics.seconds(Phase::reorder) + statistics.seconds(Phase::density));
}

void register_engines() {
  RadiusPolicy nearest, per_photon, fixed;
  nearest.kind = RadiusKind::nearest;
  nearest.k = kNearest;
  per_photon.radii = cloud().radii;
  fixed.kind = RadiusKind::fixed;
  fixed.radius = cloud().radius;
  const auto add = [](const std::string& engine, const std::string& kind, const RadiusPolicy& policy) {
    benchmark::RegisterBenchmark(("build/" + engine + "/" + kind).c_str(), engine_build, engine, policy)
        ->Arg(1)
        ->Arg(2)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
    benchmark::RegisterBenchmark(("estimate/" + engine + "/" + kind).c_str(), engine_estimate, engine, policy)
        ->Arg(1)
        ->Arg(2)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  };
  for (const std::string& engine : engine_names()) {
    if (engine_traits(engine).for_tests) continue;
    add(engine, "fixed", fixed);
    if (engine_traits(engine).takes_nearest)
      add(engine, "nearest", nearest);
    else
      add(engine, "per_photon", per_photon);
  }
}

BENCHMARK(nanoflann_nearest)->Unit(benchmark::kMillisecond);
BENCHMARK(map_nearest)->Unit(benchmark::kMillisecond);
BENCHMARK(nanoflann_radius)->Unit(benchmark::kMillisecond);
BENCHMARK(map_radius)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(public_sum, one_radius, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(public_sum, radius_for_each, false)->Unit(benchmark::kMillisecond);
BENCHMARK(nanoflann_build)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(tracing)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(tree_build)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(radii)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  constexpr std::string_view kScene = "--scene=", kSimd = "--simd=";
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with(kScene)) glowworm::bench::scene_name = argument.substr(kScene.size());
    if (argument.starts_with(kSimd)) glowworm::set_simd(std::string(argument.substr(kSimd.size())));
    auto& recorded = glowworm::bench::recorded;
    const auto number = [&](std::string_view name) {
      return argument.starts_with(name) ? std::strtoull(argv[i] + name.size(), nullptr, 10) : 0;
    };
    if (const auto photons = number("--photons=")) recorded.photons = photons;
    if (const auto side = number("--side=")) recorded.width = recorded.height = static_cast<int>(side);
    if (const auto rays = number("--rays=")) recorded.gather = static_cast<std::uint32_t>(rays);
    recorded.guided |= argument == "--guided";
  }
  benchmark::AddCustomContext("simd", glowworm::simd_name());
  benchmark::AddCustomContext("machine", glowworm::bench::machine_name());
  benchmark::AddCustomContext("commit", glowworm::bench::commit_name());
  glowworm::bench::register_engines();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
