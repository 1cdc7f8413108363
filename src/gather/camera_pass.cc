#include "gather/camera_pass.h"

#include <algorithm>
#include <span>

#include "core/make_parts.h"
#include "core/parallel.h"
#include "gather/camera_policy.h"
#include "gather/camera_rays.h"
#include "gather/light_edges.h"
#include "gather/medium_walk.h"
#include "transport/medium.h"

namespace glowworm {

namespace {

/// Pixels are traced in square blocks of this side, so that packets of rays are compact. Blocks are aligned to the
/// whole picture, not to the task, because a hit's last bits depend on the ray's packet.
constexpr int kBlock = CameraTask::kBlock;

/// Working memory, reused for one block after another.
struct BlockMemory {
  CameraRays camera;
  std::vector<Hit> hits;  // of these
  PathQueue<CameraPath> queue;
  GatherPoints points;
  VolumeSegments segments;
};

class BlockTracer {
 public:
  /// @param first_slot of the task
  BlockTracer(const Tracer& tracer, const Camera& camera, const CameraTask& task, std::size_t first_slot,
              const CameraPassSettings& settings, SlotRadiance& radiance, FirstHit& first_hit, BlockMemory& memory)
      : tracer_(tracer),
        camera_(camera),
        task_(task),
        first_slot_(first_slot),
        settings_(settings),
        radiance_(radiance),
        first_hit_(first_hit),
        memory_(memory),
        lights_(tracer, radiance),
        walk_(tracer, radiance, lights_, memory.segments, settings.photons_alone),
        policy_(tracer, settings, radiance, first_hit, lights_, memory.points, memory.queue.branches),
        edges_(tracer, camera, settings),
        crosses_media_(tracer.scene().crosses_media()),
        camera_medium_(camera_medium(tracer, camera)) {}

  void trace(int x0, int y0) {
    memory_.points.clear();
    memory_.segments.clear();
    const auto create = [&](const BlockPixels& without) {
      memory_.camera.create(camera_, task_, first_slot_, settings_, policy_.sequence, x0, y0, without);
      follow_paths(task_, [&](std::size_t) { return policy_.sequence; });
    };
    create({});
    if (!settings_.surface_samples) return;
    BlockPixels edges;
    const auto find = [&] { return edges_.find(x0, y0); };
    if (!crosses_media_) edges = settings_.edges ? settings_.edges->of_block(x0, y0, find) : find();
    for (std::uint32_t i = 0; i < kSurfaceSamples; ++i) {
      policy_.sequence = CameraSequence(kSurfaceSamples, i);
      create(edges);
    }
    if (edges.none()) return;
    policy_.sequence = CameraRays::sequence_at(0);
    for (std::uint32_t sample = 0; sample < task_.sample_count; ++sample) {
      CameraTask one = task_;
      one.first_sample += sample;
      one.sample_count = 1;
      memory_.camera.create_at(edges, camera_, one, first_slot_ + sample * task_.pixel_count(), settings_, x0, y0);
      follow_paths(one, [](std::size_t ray) { return CameraRays::sequence_at(ray); });
    }
  }
  std::uint64_t rays_traced() const { return rays_traced_ + edges_.rays; }
  std::uint64_t shadow_rays() const { return lights_.shadow_rays + edges_.shadow_rays; }

 private:
  /// Follows the paths of `memory_.camera`. @param sequence_of their random numbers, by ray
  template <typename SequenceOf>
  void follow_paths(const CameraTask& task, const SequenceOf& sequence_of) {
    PathQueue<CameraPath>& queue = memory_.queue;
    queue.clear();
    intersect_camera_rays(task.sample_count);
    for (std::size_t i = 0; i < memory_.hits.size(); ++i) see(i, memory_.camera.sample_of(i, task), sequence_of(i));
    lights_.add_waiting(radiance_.sun.empty() ? radiance_.direct : radiance_.sun);
    for (int bounce = 1; !queue.empty(); ++bounce) {
      rays_traced_ += queue.step(tracer_, [&](CameraPath& path, Hit& hit) {
        return reach(path, hit, RayOrder::incoherent) && policy_.advance(path, hit, bounce);
      });
      lights_.add_waiting(radiance_.direct);
    }
  }

  /// Traces one sample after another: the number of samples of the task must not change which rays share a packet,
  /// because the last bits of a coherent ray's hit depend on that.
  void intersect_camera_rays(std::uint32_t samples) {
    const std::span<const Ray> rays(memory_.camera.rays);
    memory_.hits.resize(rays.size());
    const std::span<Hit> hits(memory_.hits);
    const std::size_t each = rays.size() / samples;
    for (std::size_t first = 0; first < rays.size(); first += each)
      tracer_.intersect(rays.subspan(first, each), hits.subspan(first, each), RayOrder::camera);
    rays_traced_ += rays.size();
  }

  /// Processes the hit of camera ray i. Its path joins the queue if it continues.
  void see(std::size_t i, std::uint32_t sample, const CameraSequence& sequence) {
    const CameraRays& rays = memory_.camera;
    const std::uint32_t slot = rays.slot[i], pixel = rays.pixel[i];
    if (slot == kNone) return;
    const Ray& ray = rays.rays[i];
    Hit hit = memory_.hits[i];
    if (!crosses_media_ || ray.t_max < 0) {
      if (!sequence.of_surface()) first_hit_.see(slot, hit, length_to(hit));
      if (ray.t_max < 0) return;
      if (hit.triangle != kNone && policy_.ends_on_diffuse(slot, hit)) return;
    }
    Sampler sampler(SamplerKind::sobol, settings_.seed, sequence.stream_of(pixel), sequence.place_of(sample));
    // Film and lens have used the first two pairs.
    for (int taken = 0; taken < 2; ++taken) (void)sampler.next2();
    CameraPath path{{ray}, sampler, slot, pixel, sample};
    bool goes_on = true;
    if (crosses_media_) {
      path.medium = camera_medium_;
      goes_on = reach(path, hit, RayOrder::camera);
      if (!sequence.of_surface()) first_hit_.see(slot, hit, length(path.ray.origin - ray.origin) + length_to(hit));
    }
    if (goes_on && policy_.advance(path, hit, 0)) memory_.queue.paths.push_back(path);
  }

  /// Takes a path through media and interfaces. Returns false if nothing comes from behind.
  bool reach(CameraPath& path, Hit& hit, RayOrder order) {
    if (!crosses_media_) return true;
    // Surface samples see light behind media alone.
    return walk_.cross(path, hit, order, {policy_.sequence.of_surface() ? nullptr : &radiance_.medium, path.slot},
                       path.sampler);
  }

  const Tracer& tracer_;
  const Camera& camera_;
  const CameraTask& task_;
  const std::size_t first_slot_;
  const CameraPassSettings& settings_;
  SlotRadiance& radiance_;
  FirstHit& first_hit_;
  BlockMemory& memory_;
  LightAdder lights_;
  MediumWalk walk_;
  CameraPolicy policy_;
  LightEdges edges_;
  const bool crosses_media_;
  const PathMedium camera_medium_;
  std::uint64_t rays_traced_ = 0;
};

/// Whether the light of suns needs no filter. A choice among several is random, and so are estimates of what grids of
/// media let through.
bool has_sun_without_noise(const Scene& scene) {
  return scene.light_selector().directional_count() == 1 &&
         std::none_of(scene.media().begin(), scene.media().end(), [](const Medium& m) { return m.grid != nullptr; });
}

/// A block of pixels that a task covers, by its upper left corner.
struct Block {
  const CameraTask* task;
  std::size_t first_slot;  ///< of the task
  int x, y;
};

std::vector<Block> blocks_of(CameraTasks tasks) {
  std::vector<Block> blocks;
  std::size_t first_slot = 0;
  for (const CameraTask& task : tasks) {
    for (int y = task.y0 / kBlock * kBlock; y < task.y1; y += kBlock)
      for (int x = task.x0 / kBlock * kBlock; x < task.x1; x += kBlock) blocks.push_back({&task, first_slot, x, y});
    first_slot += task.slot_count();
  }
  return blocks;
}

}  // namespace

void FirstHit::resize(std::size_t slots, bool places) {
  albedo.assign(slots, RGB());
  surface_albedo.clear();
  normal.assign(slots, Vec3());
  depth.assign(slots, 0);
  triangle.assign(places ? slots : 0, kNone);
  barycentric.assign(places ? slots : 0, Vec2());
  for (std::vector<float>& value : values) value.clear();
}

void FirstHit::see(std::uint32_t slot, const Hit& hit, float distance) {
  depth[slot] = distance;
  if (triangle.empty()) return;
  triangle[slot] = hit.triangle;
  barycentric[slot] = hit.barycentric;
}

void FirstHit::see(std::uint32_t slot, const Vertex& vertex) {
  normal[slot] = shading_normal_towards(vertex.point.frame.n, vertex.point.geometric_normal, vertex.wo);
  albedo[slot] = vertex.surface().albedo(vertex.wo, kAllLobes);
}

void camera_pass(const Tracer& tracer, const Camera& camera, CameraTasks tasks, const CameraPassSettings& settings,
                 SlotRadiance& radiance, FirstHit& first_hit, GatherPoints& points, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::camera_pass);
  points.clear();
  points.reserve(tasks.slot_count());
  radiance.resize(tasks.slot_count(), !tracer.scene().media().empty());
  first_hit.resize(tasks.slot_count(), settings.places);
  if (settings.surface_samples) {
    radiance.surface_emitted.resize(tasks.slot_count());
    first_hit.surface_albedo.resize(tasks.slot_count());
    if (settings.suns && has_sun_without_noise(tracer.scene())) radiance.sun.resize(tasks.slot_count());
  }
  if (settings.segments) settings.segments->clear();
  const std::vector<Block> blocks = blocks_of(tasks);
  const auto trace = [&](std::size_t number, BlockMemory& memory) {
    const Block& block = blocks[number];
    BlockTracer block_tracer(tracer, camera, *block.task, block.first_slot, settings, radiance, first_hit, memory);
    block_tracer.trace(block.x, block.y);
    statistics.add(Counter::camera_rays, block_tracer.rays_traced());
    if (block_tracer.shadow_rays() > 0) statistics.add(Counter::occlusion_rays, block_tracer.shadow_rays());
  };
  make_parts<BlockMemory>(blocks.size(), trace, [&](const BlockMemory& block) {
    points.append(block.points);
    if (settings.segments) settings.segments->append(block.segments);
  });
  parallel_for_each(radiance.sun.size(), 4096, [&](std::size_t i) { radiance.direct[i] += radiance.sun[i]; });
  statistics.add(Counter::gather_points, points.size());
}

GatherPoints camera_pass(const Tracer& tracer, const Camera& camera, CameraTasks tasks,
                         const CameraPassSettings& settings, SlotRadiance& radiance, FirstHit& first_hit,
                         Statistics& statistics) {
  GatherPoints points;
  camera_pass(tracer, camera, tasks, settings, radiance, first_hit, points, statistics);
  return points;
}

}  // namespace glowworm
