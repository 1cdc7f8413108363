// Volume photons and beams along segments: pairs a second of the kernels on one thread, beside plain twins of them, and
// beside a march that looks photons up in spheres around points along each segment.
// --photons=N and --beams=N say how many there are, --k=N how many of them a radius holds; --simd=NAME is that of
// `glowworm render`.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/parallel.h"
#include "core/random.h"
#include "density/knn.h"
#include "density/volume_map.h"
#include "kernels/simd.h"
#include "kernels/volume_reference.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

std::uint32_t photon_count = 1'000'000, beam_count = 200'000, held = 10;
/// A room of fog: its side in metres, and the fog's coefficient in m^-1.
constexpr float kSide = 4, kSigma = 0.4f;

float number(std::uint32_t i, std::uint32_t which) { return to_unit_float(hash_combine(hash32(i), which)); }
Vec3 place(std::uint32_t i, std::uint32_t which) {
  return Vec3{number(i, which), number(i, which + 1), number(i, which + 2)} * kSide;
}
Vec3 direction(std::uint32_t i, std::uint32_t which) {
  const float z = 2 * number(i, which) - 1, phi = 2 * kPi * number(i, which + 1), r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// The distance from a place in the room to its walls.
float to_wall(Vec3 p, Vec3 d) {
  float nearest = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis)
    if (d[axis] != 0) nearest = std::min(nearest, ((d[axis] > 0 ? kSide : 0) - p[axis]) / d[axis]);
  return std::max(nearest, 0.0f);
}

constexpr std::uint32_t kCamera = 0, kGather = 1, kScattered = 2;

/// Segments to the walls: of a camera's pixels; of gather rays from points of the floor, neighbours in the same cell of
/// directions together; from anywhere to anywhere. @param g of the phase function
VolumeSegments segments_of(std::uint32_t kind, float g) {
  const SegmentMedium medium{RGB(kSigma), RGB(kSigma), g, 0};
  VolumeSegments segments;
  const auto add = [&](Vec3 p, Vec3 d) { segments.push_back(p, d, to_wall(p, d), medium, RGB(1.0f), 0); };
  constexpr std::uint32_t kPixels = 128, kPoints = 32, kCells = 4;
  if (kind == kCamera)
    for (std::uint32_t i = 0; i < kPixels * kPixels; ++i) {
      const float x = (static_cast<float>(i % kPixels) + number(i, 1)) / kPixels - 0.5f;
      const float y = (static_cast<float>(i / kPixels) + number(i, 2)) / kPixels - 0.5f;
      add({kSide / 2, kSide / 2, 0}, normalize({x, y, 0.8f}));
    }
  if (kind == kGather)
    for (std::uint32_t cell = 0; cell < kCells * kCells; ++cell)
      for (std::uint32_t i = 0; i < kPoints * kPoints; ++i) {
        const std::uint32_t n = cell * kPoints * kPoints + i;
        const float u = (static_cast<float>(cell % kCells) + number(n, 1)) / kCells;
        const float v = (static_cast<float>(cell / kCells) + number(n, 2)) / kCells;
        const float phi = 2 * kPi * v, r = std::sqrt(u);
        const Vec3 p{(static_cast<float>(i % kPoints) + 0.5f) / kPoints, 0,
                     (static_cast<float>(i / kPoints) + 0.5f) / kPoints};
        add(p * (kSide / 2), {r * std::cos(phi), std::sqrt(1 - u), r * std::sin(phi)});
      }
  if (kind == kScattered)
    for (std::uint32_t i = 0; i < 4096; ++i) add(place(i, 40), direction(i, 43));
  return segments;
}

struct Cloud {
  VolumePhotons photons;
  VolumeBeams beams;
  PhotonKernels kernels;
  BeamPieces pieces;
  VolumeMap photon_map, beam_map;

  Cloud() {
    for (std::uint32_t i = 0; i < photon_count; ++i) photons.push_back(place(i, 1), direction(i, 4), RGB(1.0f), 0, 0);
    for (std::uint32_t i = 0; i < beam_count; ++i) {
      const Vec3 p = place(i, 1), d = direction(i, 4);
      beams.push_back(p, d, std::min(-std::log(1 - number(i, 6)) / kSigma, to_wall(p, d)), RGB(1.0f), 0, 0);
    }
    kernels = volume_photon_kernels(photons, held);
    pieces = volume_beam_pieces(beams, held);
    // Segments meet all beams.
    pieces.parts.clear();
    Statistics statistics;
    photon_map.build(photons, photons.flux, kernels, 1, statistics);
    beam_map.build(beams, beams.flux, pieces, 1, statistics);
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

void map_sum(benchmark::State& state, bool beams, std::uint32_t kind, float g) {
  const VolumeMap& map = beams ? cloud().beam_map : cloud().photon_map;
  const VolumeSegments segments = segments_of(kind, g);
  std::vector<RGB> found(segments.size(), RGB(0.0f));
  Statistics statistics;
  set_thread_count(1);
  for (auto _ : state) map.estimate(segments, found, statistics);
  set_thread_count(0);
  const double runs = static_cast<double>(state.iterations());
  const double used = static_cast<double>(statistics.count(Counter::shader_operations));
  const double tested = static_cast<double>(statistics.count(Counter::pairs_tested));
  set_rate(state, "segments", static_cast<double>(segments.size()));
  set_rate(state, "pairs", tested / runs);
  set_rate(state, "used_pairs", used / runs);
  state.counters["used"] = used / tested;
}

/// The plain twins of the kernels, compiled as the rest of the program is: every photon or piece of a small cloud
/// against segments of a camera.
void plain(benchmark::State& state, bool beams) {
  const VolumeSegments segments = segments_of(kCamera, 0);
  VolumePhotons photons;
  VolumeBeams some;
  constexpr std::uint32_t kSome = 2048;
  for (std::uint32_t i = 0; i < kSome; ++i) {
    photons.push_back(place(i, 1), direction(i, 4), RGB(1.0f), 0, 0);
    some.push_back(place(i, 1), direction(i, 4), 0.5f, RGB(1.0f), 0, 0);
  }
  const BeamPieces pieces = volume_beam_pieces(some, held);
  PhotonKernels kernels = volume_photon_kernels(photons, held);
  kernels.radii.assign(kSome, 0.25f * kSide);
  const VolumeIndex index =
      beams ? VolumeIndex(some, some.flux, pieces, 1) : VolumeIndex(photons, photons.flux, kernels, 1);
  const VolumeTree tree = index.tree(index.media()[0]);
  const std::size_t blocks = (beams ? pieces.radii.size() : kSome) / kVolumeBlock;
  SegmentTile tile{};
  tile.count = kSegmentTile;
  for (std::size_t i = 0; i < kSegmentTile; ++i) {
    const std::size_t s = i * segments.size() / kSegmentTile;
    for (int axis = 0; axis < 3; ++axis) {
      tile.origin[axis][i] = segments.origin[s][axis];
      tile.direction[axis][i] = segments.direction[s][axis];
      tile.sigma_t[axis][i] = kSigma;
    }
    tile.length[i] = segments.length[s];
  }
  VolumeCounts counts;
  for (auto _ : state) {
    if (beams)
      sum_volume_reference(tree.beams, blocks, tile, counts);
    else
      sum_volume_reference(tree.photons, blocks, tile, counts);
    benchmark::DoNotOptimize(tile.sum[0][0]);
  }
  const double runs = static_cast<double>(state.iterations());
  set_rate(state, "pairs", static_cast<double>(counts.tested) / runs);
  set_rate(state, "used_pairs", static_cast<double>(counts.evaluated) / runs);
  state.counters["used"] = static_cast<double>(counts.evaluated) / static_cast<double>(counts.tested);
}

/// A march along each segment in steps of the mean radius: the photons in a sphere around each point, by the kd-tree.
void march(benchmark::State& state, std::uint32_t kind) {
  const Cloud& c = cloud();
  const VolumeSegments segments = segments_of(kind, 0);
  PhotonPlaces places;
  places.build(c.photons.position, c.photons.position, {});
  double mean = 0;
  for (const float r : c.kernels.radii) mean += double{r} / static_cast<double>(c.kernels.size());
  const auto radius = static_cast<float>(mean);
  std::vector<FoundPhoton> found;
  std::uint64_t tested = 0;
  double pairs = 0, sum = 0;
  for (auto _ : state) {
    // Every 16th segment is enough.
    for (std::size_t i = 0; i < segments.size(); i += 16)
      for (float t = radius / 2; t < segments.length[i]; t += radius) {
        const Vec3 p = segments.origin[i] + segments.direction[i] * t;
        places.within(p, p, -std::numeric_limits<float>::infinity(), radius, found, tested);
        double here = 0;
        for (const FoundPhoton& photon : found) here += 1 - photon.distance_squared / (radius * radius);
        sum += here * std::exp(-kSigma * t);
        pairs += static_cast<double>(found.size());
      }
    benchmark::DoNotOptimize(sum);
  }
  const double runs = static_cast<double>(state.iterations());
  set_rate(state, "segments", std::ceil(static_cast<double>(segments.size()) / 16));
  set_rate(state, "pairs", static_cast<double>(tested) / runs);
  set_rate(state, "used_pairs", pairs / runs);
  state.counters["used"] = pairs / static_cast<double>(tested);
}

void build(benchmark::State& state, bool beams) {
  const Cloud& c = cloud();
  Statistics statistics;
  VolumeMap map;
  set_thread_count(1);
  for (auto _ : state) {
    if (beams)
      map.build(c.beams, c.beams.flux, c.pieces, 1, statistics);
    else
      map.build(c.photons, c.photons.flux, c.kernels, 1, statistics);
  }
  set_thread_count(0);
  set_rate(state, "photons", static_cast<double>(beams ? c.beams.size() : c.photons.size()));
}

void radii(benchmark::State& state, bool beams) {
  const Cloud& c = cloud();
  set_thread_count(1);
  for (auto _ : state) {
    if (beams)
      benchmark::DoNotOptimize(volume_beam_pieces(c.beams, held).radii.data());
    else
      benchmark::DoNotOptimize(volume_photon_kernels(c.photons, held).radii.data());
  }
  set_thread_count(0);
  set_rate(state, "photons", static_cast<double>(beams ? c.beams.size() : c.photons.size()));
}

BENCHMARK_CAPTURE(map_sum, points_camera, false, kCamera, 0.0f)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(map_sum, points_camera_glossy, false, kCamera, 0.6f)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(map_sum, points_gather, false, kGather, 0.0f)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(map_sum, points_scattered, false, kScattered, 0.0f)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(map_sum, beams_camera, true, kCamera, 0.0f)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(map_sum, beams_camera_glossy, true, kCamera, 0.6f)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(map_sum, beams_gather, true, kGather, 0.0f)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(map_sum, beams_scattered, true, kScattered, 0.0f)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(plain, points, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(plain, beams, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(march, camera, kCamera)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(march, gather, kGather)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(build, points, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(build, beams, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(radii, points, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(radii, beams, true)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  constexpr std::string_view kSimd = "--simd=";
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with(kSimd)) glowworm::set_simd(std::string(argument.substr(kSimd.size())));
    const auto number = [&](std::string_view name, std::uint32_t& value) {
      if (argument.starts_with(name))
        value = static_cast<std::uint32_t>(std::strtoul(argv[i] + name.size(), nullptr, 10));
    };
    number("--photons=", glowworm::bench::photon_count);
    number("--beams=", glowworm::bench::beam_count);
    number("--k=", glowworm::bench::held);
  }
  benchmark::AddCustomContext("simd", glowworm::simd_name());
  benchmark::AddCustomContext("machine", glowworm::bench::machine_name());
  benchmark::AddCustomContext("commit", glowworm::bench::commit_name());
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
