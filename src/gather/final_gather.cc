#include "gather/final_gather.h"

#include <algorithm>
#include <vector>

#include "core/make_parts.h"
#include "core/random.h"
#include "gather/gather_policy.h"
#include "gather/medium_walk.h"
#include "transport/path_queue.h"

namespace glowworm {

namespace {

/// Final gather rays per piece of parallel work.
constexpr std::size_t kRaysPerChunk = 32768;
/// Of these, so many, or one stratum, are traced at a time: their arrays fit into the second-level cache.
constexpr std::size_t kRaysAtOnce = 2048;

/// Gather points of each chunk except the last, which may have fewer.
std::size_t points_of_chunk(std::uint32_t rays_each) {
  return std::clamp<std::size_t>(kRaysPerChunk / rays_each, 1, kRaysAtOnce);
}

/// Strata of a chunk that are traced at a time. All chunks use the same number, whatever their size, so that the light
/// of a point is summed in the same order in any task.
std::uint32_t strata_under_way(std::uint32_t rays_each) {
  return static_cast<std::uint32_t>(std::max<std::size_t>(1, kRaysAtOnce / points_of_chunk(rays_each)));
}

/// Working memory, reused for one chunk after another.
struct ChunkMemory {
  PathQueue<GatherPath> rays;
  QueryPoints queries, caustic_queries;
  VolumeSegments segments;

  void clear() {
    rays.clear();
    queries.clear();
    caustic_queries.clear();
    segments.clear();
  }
};

class ChunkGatherer {
 public:
  ChunkGatherer(const Tracer& tracer, const GatherPoints& points, const FinalGatherSettings& settings,
                SlotRadiance& radiance, QueryPoints* caustic_queries, ChunkMemory& memory)
      : tracer_(tracer),
        points_(points),
        settings_(settings),
        radiance_(radiance),
        queries_(memory.queries),
        rays_(memory.rays),
        lights_(tracer, radiance),
        walk_(tracer, radiance, lights_, memory.segments, settings.photons_alone),
        policy_(tracer, points, settings, maker_, radiance, lights_, memory.queries, caustic_queries) {}

  void gather(std::size_t first, std::size_t last) {
    std::vector<std::uint32_t> order;
    coherent_order(points_, first, last, order);
    maker_.prepare(points_, order, settings_.rays, settings_.seed, settings_.guide);
    queries_.reserve(order.size() * settings_.rays);
    const std::uint32_t strata_at_once = strata_under_way(settings_.rays);
    for (std::uint32_t stratum = 0; stratum < settings_.rays; stratum += strata_at_once) {
      maker_.create(stratum, std::min(settings_.rays, stratum + strata_at_once), rays_.paths);
      follow();
    }
    if (!settings_.looks_at_patches()) return;
    create_patch_rays(tracer_.scene(), *settings_.bright, points_, order,
                      {settings_.rays, settings_.patch_samples, settings_.seed}, rays_.paths);
    follow();
  }

  std::uint64_t rays_traced = 0;
  std::uint64_t shadow_rays() const { return lights_.shadow_rays; }

 private:
  /// Follows rays from their gather points to their ends.
  void follow() {
    if (!points_.media.empty())
      for (GatherPath& path : rays_.paths)
        path.medium = points_.media[path.point].towards(path.ray.direction, points_.normal[path.point]);
    for (std::uint32_t step = 0; !rays_.empty(); ++step)
      rays_traced += rays_.step(tracer_, [&](GatherPath& path, Hit& hit) {
        return (!crosses_media_ || cross_media(path, hit, step)) && policy_.advance(path, hit, step);
      });
  }

  /// Takes a ray through media and interfaces. Returns false if nothing comes from behind.
  bool cross_media(GatherPath& path, Hit& hit, std::uint32_t step) {
    Sampler sampler = policy_.sampler_of(path, kMediumStream + step);
    // Rays to patches find the light of these alone.
    std::vector<RGB>* const part = path.segment == Segment::to_patch ? nullptr : &radiance_.indirect;
    return walk_.cross(path, hit, RayOrder::incoherent, {part, points_.slot[path.point], true}, sampler);
  }

  const Tracer& tracer_;
  const GatherPoints& points_;
  const FinalGatherSettings& settings_;
  SlotRadiance& radiance_;
  QueryPoints& queries_;
  PathQueue<GatherPath>& rays_;
  GatherRayMaker maker_;
  LightAdder lights_;
  MediumWalk walk_;
  GatherPolicy policy_;
  const bool crosses_media_ = tracer_.scene().crosses_media();
};

}  // namespace

void final_gather(const Tracer& tracer, const GatherPoints& points, std::size_t first, std::size_t last,
                  const FinalGatherSettings& settings, SlotRadiance& radiance, const GatherQueries& found,
                  Statistics& statistics) {
  QueryPoints& queries = found.queries;
  QueryPoints* const caustic_queries = found.caustic_queries;
  const PhaseTimer timer(statistics, Phase::gather_rays);
  queries.clear();
  if (caustic_queries) caustic_queries->clear();
  if (found.segments) found.segments->clear();
  if (first >= last || settings.rays == 0) return;
  queries.reserve((last - first) * (settings.rays + (settings.looks_at_patches() ? settings.patch_samples : 0)));
  const std::size_t per_chunk = points_of_chunk(settings.rays);
  const std::size_t chunks = (last - first + per_chunk - 1) / per_chunk;
  const auto gather = [&](std::size_t chunk, ChunkMemory& memory) {
    const std::size_t begin = first + chunk * per_chunk, end = std::min(begin + per_chunk, last);
    memory.clear();
    ChunkGatherer gatherer(tracer, points, settings, radiance, caustic_queries ? &memory.caustic_queries : nullptr,
                           memory);
    gatherer.gather(begin, end);
    statistics.add(Counter::gather_rays, gatherer.rays_traced);
    statistics.add(Counter::occlusion_rays, gatherer.shadow_rays());
  };
  make_parts<ChunkMemory>(chunks, gather, [&](const ChunkMemory& chunk) {
    queries.append(chunk.queries);
    if (caustic_queries) caustic_queries->append(chunk.caustic_queries);
    if (found.segments) found.segments->append(chunk.segments);
  });
}

void complete(const QueryPoints& queries, std::span<const RGB> queried, std::span<RGB> target, Statistics& statistics,
              float factor) {
  const PhaseTimer timer(statistics, Phase::completion);
  for (std::size_t i = 0; i < queries.size(); ++i)
    target[queries.gather_point[i]] += queries.weight[i] * (queried[i] * factor);
}

}  // namespace glowworm
