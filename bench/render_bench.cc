// Photons: how many a second, on one thread and on all. (Rays: ray_bench.)
#include <benchmark/benchmark.h>

#include "builtin/builtin.h"
#include "core/parallel.h"
#include "photon/photon_tracer.h"
#include "trace/tracer.h"

namespace glowworm::bench {
namespace {

void photons(benchmark::State& state) {
  static const Scene scene(builtin_scene("atrium"));
  static const Tracer tracer(scene);
  set_thread_count(static_cast<int>(state.range(0)));
  PhotonPassSettings settings;
  settings.photons = 500'000;
  std::int64_t stored = 0;
  for (auto _ : state) {
    Statistics statistics;
    stored += static_cast<std::int64_t>(trace_photons(tracer, settings, statistics).global.size());
  }
  state.SetItemsProcessed(stored);
}

// 0 threads: as many as there are cores.
BENCHMARK(photons)->Arg(1)->Arg(0)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace glowworm::bench

BENCHMARK_MAIN();
