// Rays and photons: how many a second, on one thread and on all.
// Rays are traced in batches, as the renderer does; the camera's and those of diffuse bounces from what it sees.
#include <benchmark/benchmark.h>

#include <limits>
#include <memory>
#include <vector>

#include "builtin/builtin.h"
#include "core/frame.h"
#include "core/offset_origin.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/warp.h"
#include "photon/photon_tracer.h"
#include "scene/surface.h"
#include "trace/tracer.h"

namespace glowworm::bench {
namespace {

constexpr int kSide = 512;
constexpr std::size_t kBatch = 4096;

/// The atrium, its camera's rays, and one diffuse bounce from each of their hits.
struct Atrium {
  Scene scene{builtin_scene("atrium")};
  Tracer tracer{scene};
  std::vector<Ray> camera, diffuse;

  Atrium() {
    const Camera& view = scene.camera("");
    // Blocks of 4x4 pixels, so that a packet of 16 rays is compact.
    for (int block = 0; block < kSide * kSide / 16; ++block)
      for (int i = 0; i < 16; ++i) {
        const int x = block % (kSide / 4) * 4 + i % 4, y = block / (kSide / 4) * 4 + i / 4;
        const CameraRay r = generate_ray(view, {x + 0.5f, y + 0.5f}, kSide, kSide, {0.5f, 0.5f});
        camera.push_back({r.origin, 0, r.direction, std::numeric_limits<float>::infinity()});
      }
    for (std::size_t i = 0; i < camera.size(); ++i) {
      const Hit hit = tracer.intersect(camera[i]);
      if (hit.triangle == kNone) continue;
      const SurfacePoint p = surface_point(scene, hit.triangle, hit.barycentric);
      const Vec3 n = face_forward(p.geometric_normal, -camera[i].direction);
      Sampler sampler(SamplerKind::independent, 0, 0, static_cast<std::uint32_t>(i));
      const Vec3 direction = Frame::from_normal(n).to_world(square_to_cosine_hemisphere(sampler.next2()));
      diffuse.push_back({offset_origin(p.position, n, p.offset), 0, direction, std::numeric_limits<float>::infinity()});
    }
  }
};

const Atrium& atrium() {
  static const Atrium scene;
  return scene;
}

void trace(benchmark::State& state, const std::vector<Ray>& rays, RayOrder order) {
  std::vector<Hit> hits(rays.size());
  for (auto _ : state) {
    parallel_for(0, rays.size(), kBatch, [&](std::size_t first, std::size_t last) {
      atrium().tracer.intersect(std::span(rays).subspan(first, last - first),
                                std::span(hits).subspan(first, last - first), order);
    });
    benchmark::DoNotOptimize(hits.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(rays.size()) * state.iterations());
}

void camera_rays(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(0)));
  trace(state, atrium().camera, RayOrder::camera);
}

void diffuse_rays(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(0)));
  trace(state, atrium().diffuse, RayOrder::incoherent);
}

void photons(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(0)));
  PhotonPassSettings settings;
  settings.photons = 500'000;
  std::int64_t stored = 0;
  for (auto _ : state) {
    Statistics statistics;
    stored += static_cast<std::int64_t>(trace_photons(atrium().tracer, settings, statistics).global.size());
  }
  state.SetItemsProcessed(stored);
}

// 0 threads: as many as there are cores.
BENCHMARK(camera_rays)->Arg(1)->Arg(0)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(diffuse_rays)->Arg(1)->Arg(0)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(photons)->Arg(1)->Arg(0)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace glowworm::bench

BENCHMARK_MAIN();
