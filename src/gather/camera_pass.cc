#include "gather/camera_pass.h"

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/make_parts.h"
#include "core/random.h"
#include "gather/camera_rays.h"
#include "gather/medium_walk.h"
#include "transport/light_connection.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// Pixels are traced in square blocks of this side, so that packets of rays are compact. Blocks are aligned to the
/// whole picture, not to the task, because a hit's last bits depend on the ray's packet.
constexpr int kBlock = CameraTask::kBlock;
/// Up to this many bounces, surface samples follow both reflection and refraction by clear glass. With a random choice,
/// a lamp that is rarely chosen would make single bright pixels.
constexpr int kSplitBounces = 4;

/// State of a camera path between bounces.
struct CameraPath : PathState {
  Sampler sampler;
  std::uint32_t slot, sequence, sample;
  bool smooth = true;  ///< every bounce was at smooth_lobes(); known with CameraPassSettings::glints_apart
};

/// Working memory, reused for one block after another.
struct BlockMemory {
  CameraRays camera;
  std::vector<Ray> rays;  // of the paths
  std::vector<Hit> hits;
  std::vector<CameraPath> paths;        // paths that continue through a specular bounce
  std::vector<CameraPath> split_paths;  // of surface samples that continue on a second path
  GatherPoints points;                  // the one or the other
  QueryPoints queries;
  VolumeSegments segments;
  // Light of directional lights that surface samples find at one bounce, before shadow rays.
  std::vector<UnoccludedLight> suns;
  std::vector<std::uint32_t> sun_slots;
};

class BlockTracer {
 public:
  /// @param first_slot of the task
  /// @param as_queries make query points instead of gather points
  BlockTracer(const Tracer& tracer, const Camera& camera, const CameraTask& task, std::size_t first_slot,
              const CameraPassSettings& settings, bool as_queries, SlotRadiance& radiance, FirstHit& first_hit,
              BlockMemory& memory)
      : tracer_(tracer),
        camera_(camera),
        task_(task),
        first_slot_(first_slot),
        settings_(settings),
        as_queries_(as_queries),
        radiance_(radiance),
        first_hit_(first_hit),
        memory_(memory),
        camera_rays_(memory.camera),
        hits_(memory.hits),
        paths_(memory.paths),
        walk_(tracer, radiance, memory.segments, settings.photons_alone),
        crosses_media_(tracer.scene().crosses_media()),
        in_media_(!tracer.scene().media().empty()),
        camera_medium_(camera_medium(tracer, camera)) {}

  void trace(int x0, int y0) {
    memory_.points.clear();
    memory_.queries.clear();
    memory_.segments.clear();
    follow_paths(x0, y0);
    for (std::uint32_t i = 0; settings_.surface_samples && i < kSurfaceSamples; ++i) {
      sequence_ = CameraSequence(i);
      follow_paths(x0, y0);
    }
  }
  std::uint64_t rays_traced() const { return rays_traced_; }
  std::uint64_t shadow_rays() const { return walk_.shadow_rays + sun_rays_; }

 private:
  void follow_paths(int x0, int y0) {
    paths_.clear();
    camera_rays_.create(camera_, task_, first_slot_, settings_, sequence_, x0, y0);
    intersect_camera_rays();
    for (std::size_t i = 0; i < camera_rays_.rays.size(); ++i) see(i);
    keep_paths(paths_.size());
    add_suns();
    for (int bounce = 1; !paths_.empty(); ++bounce) {
      intersect();
      std::size_t kept = 0;
      for (std::size_t i = 0; i < hits_.size(); ++i)
        if (reach(paths_[i], hits_[i], RayOrder::incoherent) && advance(paths_[i], hits_[i], bounce))
          paths_[kept++] = paths_[i];
      keep_paths(kept);
      add_suns();
    }
  }

  /// Keeps that many paths, and adds those that were split off.
  void keep_paths(std::size_t kept) {
    paths_.erase(paths_.begin() + static_cast<std::ptrdiff_t>(kept), paths_.end());
    paths_.insert(paths_.end(), memory_.split_paths.begin(), memory_.split_paths.end());
    memory_.split_paths.clear();
  }

  void intersect() {
    memory_.rays.clear();
    for (const CameraPath& path : paths_) memory_.rays.push_back(path.ray);
    hits_.resize(paths_.size());
    tracer_.intersect(memory_.rays, hits_, RayOrder::incoherent);
    rays_traced_ += hits_.size();
  }

  /// Traces one sample after another: the number of samples of the task must not change which rays share a packet,
  /// because the last bits of a coherent ray's hit depend on that.
  void intersect_camera_rays() {
    const std::span<const Ray> rays(camera_rays_.rays);
    hits_.resize(rays.size());
    const std::size_t each = rays.size() / task_.sample_count;
    for (std::size_t first = 0; first < rays.size(); first += each)
      tracer_.intersect(rays.subspan(first, each), std::span(hits_).subspan(first, each), RayOrder::camera);
    rays_traced_ += rays.size();
  }

  /// Processes the hit of camera ray i. Appends its path if it continues.
  void see(std::size_t i) {
    const std::uint32_t slot = camera_rays_.slot[i], pixel = camera_rays_.pixel[i];
    if (slot == CameraRays::kNoSlot) return;
    const Ray& ray = camera_rays_.rays[i];
    Hit hit = hits_[i];
    if (!crosses_media_ || ray.t_max < 0) {
      if (!sequence_.of_surface()) record_hit(slot, hit, length_to(hit));
      if (ray.t_max < 0) return;
      if (hit.triangle != kNone && ends_on_diffuse(slot, ray, hit)) return;
    }
    const std::uint32_t sample = camera_rays_.sample_of(i, task_);
    Sampler sampler(SamplerKind::sobol, settings_.seed, sequence_.stream_of(pixel), sequence_.place_of(sample));
    // Film and lens have used the first two pairs.
    for (int taken = 0; taken < 2; ++taken) (void)sampler.next2();
    paths_.push_back({{ray}, sampler, slot, pixel, sample});
    CameraPath& path = paths_.back();
    bool goes_on = true;
    if (crosses_media_) {
      path.medium = camera_medium_;
      goes_on = reach(path, hit, RayOrder::camera);
      if (!sequence_.of_surface()) record_hit(slot, hit, length(path.ray.origin - ray.origin) + length_to(hit));
    }
    if (!goes_on || !advance(path, hit, 0)) paths_.pop_back();
  }

  /// Takes a path through media and interfaces. Returns false if nothing comes from behind.
  bool reach(CameraPath& path, Hit& hit, RayOrder order) {
    if (!crosses_media_) return true;
    // Surface samples see light behind media alone.
    return walk_.cross(path, hit, order, {sequence_.of_surface() ? nullptr : &radiance_.medium, path.slot},
                       path.sampler);
  }

  void record_hit(std::uint32_t slot, const Hit& hit, float depth) {
    first_hit_.depth[slot] = depth;
    if (!settings_.places) return;
    first_hit_.triangle[slot] = hit.triangle;
    first_hit_.barycentric[slot] = hit.barycentric;
  }

  /// A fast version of advance() for surfaces that only reflect diffusely, where no gather point is needed. Returns
  /// false for others.
  bool ends_on_diffuse(std::uint32_t slot, const Ray& ray, const Hit& hit) {
    if (sequence_.of_surface() ? takes_suns() : !as_queries_) return false;
    DiffusePoint point;
    if (!diffuse_vertex(tracer_.scene(), hit, point)) return false;
    if (sequence_.of_surface()) {
      add_surface_sample(first_hit_.surface_albedo, slot, point.reflectance);
      return true;
    }
    Vec3 shading_normal;
    if (!diffuse_shading_normal(tracer_.scene(), hit.triangle, hit.barycentric, point, shading_normal)) return false;
    const Vec3 wo = -ray.direction;
    first_hit_.normal[slot] = shading_normal_towards(shading_normal, point.geometric_normal, wo);
    first_hit_.albedo[slot] = point.reflectance;
    add_query(memory_.queries, point, wo, RGB(1.0f), slot);
    return true;
  }

  static void add_surface_sample(std::vector<RGB>& target, std::uint32_t slot, RGB value) {
    target[slot] += value * (1.0f / kSurfaceSamples);
  }

  /// What camera paths do on their step.
  struct Policy {
    BlockTracer& tracer;
    CameraPath& path;
    int bounce;

    bool finds_light() const { return true; }
    template <typename Density>
    void add_light(RGB light, std::uint32_t source, Density&& density) {
      tracer.add_emitted(path.slot, path.throughput * light * weight_of_met_light(path, density), source);
    }
    float wavelength_number() { return path.sampler.next1(); }
    bool scatter(const Vertex& vertex) { return tracer.scatter(path, vertex, bounce); }
  };

  /// Processes a path's hit. Returns true if the path continues through a specular bounce.
  bool advance(CameraPath& path, const Hit& hit, int bounce) {
    return meet(tracer_.scene(), path, hit, Policy{*this, path, bounce});
  }

  bool scatter(CameraPath& path, const Vertex& vertex, int bounce) {
    if (bounce == 0) record_surface(path, vertex);
    // Surface samples see light through the specular lobes, and that of directional lights.
    if (takes_suns()) find_sun(path, vertex);
    if (sequence_.of_surface()) return vertex.has(kSpecular) && follow_surface_sample(path, vertex, bounce);
    const float broad = broad_probability(vertex);
    if (broad >= 1 || path.sampler.next1() < broad) {
      add_point(path, vertex, path.throughput / broad);
      return false;
    }
    path.throughput *= 1 / (1 - broad);
    return follow(path, vertex, bounce);
  }

  /// Whether this path finds the light of directional lights.
  bool takes_suns() const { return settings_.suns && sequence_.of_surface(); }

  /// Takes one of the directional lights as the sun of a vertex, with all lobes that are not smooth.
  void find_sun(CameraPath& path, const Vertex& vertex) {
    if (!takes_light_samples(vertex.bsdf)) return;
    LightSample sample = sample_directional(tracer_.scene(), vertex.point.position, path.sampler.next1());
    sample.pdf *= kSurfaceSamples;
    UnoccludedLight light = reflected_light(sample, vertex, kAllLobes, kAllLobes);
    if (is_black(light.radiance)) return;
    light.radiance *= path.throughput;
    memory_.suns.push_back(light);
    memory_.sun_slots.push_back(path.slot);
  }

  /// Adds the suns that nothing hides.
  void add_suns() {
    if (memory_.suns.empty()) return;
    const std::vector<RGB> passed = passed_shares(tracer_, memory_.suns);
    for (std::size_t i = 0; i < passed.size(); ++i)
      if (!is_black(passed[i]))
        radiance_.add(radiance_.direct, memory_.sun_slots[i], memory_.suns[i].radiance * passed[i],
                      memory_.suns[i].source);
    sun_rays_ += passed.size();
    memory_.suns.clear();
    memory_.sun_slots.clear();
  }

  void record_surface(const CameraPath& path, const Vertex& vertex) {
    const RGB albedo = vertex.surface().albedo(vertex.wo, kAllLobes);
    if (sequence_.of_surface()) {
      add_surface_sample(first_hit_.surface_albedo, path.slot, albedo);
      return;
    }
    first_hit_.normal[path.slot] =
        shading_normal_towards(vertex.point.frame.n, vertex.point.geometric_normal, vertex.wo);
    first_hit_.albedo[path.slot] = albedo;
  }

  void add_emitted(std::uint32_t slot, RGB light, std::uint32_t source) {
    if (sequence_.of_surface())
      add_surface_sample(radiance_.surface_emitted, slot, light);
    else
      radiance_.add(radiance_.emitted, slot, light, source);
  }

  void add_point(const CameraPath& path, const Vertex& vertex, RGB throughput) {
    if (as_queries_)
      add_query(memory_.queries, vertex, throughput, path.slot);
    else
      add_gather_point(memory_.points, vertex, throughput, path.slot, path.sequence, path.sample, in_media_);
  }

  /// Continues through the specular lobes of the surface, and adds the light of lamps that rough ones reflect.
  bool follow(CameraPath& path, const Vertex& vertex, int bounce) {
    Sampler& sampler = path.sampler;
    const Scene& scene = tracer_.scene();
    const float u_lobe = sampler.next1();
    const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, sampler.next2(), kSpecular);
    const Vec2 pair = sampler.next2();
    const float u = sampler.next1();
    if (takes_light_samples(vertex.bsdf)) {
      const LightSample sample = sample_light(scene, vertex, pair, u);
      const UnoccludedLight light = reflected_light(sample, vertex, kSpecular, kSpecular);
      const bool is_apart =
          (settings_.glints_apart && path.smooth && sample.delta) || (settings_.suns && sample.is_directional());
      if (!is_black(light.radiance) && !is_apart)
        radiance_.add(radiance_.direct, path.slot, path.throughput * light.radiance * passed_share(tracer_, light),
                      light.source);
    }
    if (settings_.glints_apart) path.smooth &= smooth_lobes(vertex).count > 0;
    return leave(path, vertex, s, s.weight) && survives(path, max_component(path.throughput), kLeastOfChains, bounce);
  }

  /// Continues through the specular lobes, for lamps that are seen through them.
  bool follow_surface_sample(CameraPath& path, const Vertex& vertex, int bounce) {
    const ShadedSurface surface = vertex.surface();
    const float u_lobe = path.sampler.next1();
    const Vec2 u = path.sampler.next2();
    if (bounce < kSplitBounces) {
      const SmoothLobes lobes = smooth_lobes(vertex);
      if (lobes.count == 2) {
        const auto& [first, last] = lobes.ray;
        memory_.split_paths.push_back(path);
        if (!leave(memory_.split_paths.back(), vertex, last, last.weight * last.pdf)) memory_.split_paths.pop_back();
        return leave(path, vertex, first, first.weight * first.pdf);
      }
    }
    const ScatteredRay s = surface.sample(vertex.wo, u_lobe, u, kSpecular);
    // Not by throughput: splitting makes it small, and would end paths. The first bounces are not left to chance.
    return leave(path, vertex, s, s.weight) &&
           (bounce < kSplitBounces || survives(path, max_component(s.weight), 1, bounce));
  }

  static bool survives(CameraPath& path, float weight, float least, int bounce) {
    return survive(path, weight, least, bounce + 1, [&] { return path.sampler.next1(); }) > 0;
  }

  const Tracer& tracer_;
  const Camera& camera_;
  const CameraTask& task_;
  const std::size_t first_slot_;
  const CameraPassSettings& settings_;
  const bool as_queries_;
  SlotRadiance& radiance_;
  FirstHit& first_hit_;
  BlockMemory& memory_;
  CameraRays& camera_rays_;
  std::vector<Hit>& hits_;
  std::vector<CameraPath>& paths_;
  MediumWalk walk_;
  const bool crosses_media_, in_media_;
  const PathMedium camera_medium_;
  CameraSequence sequence_;
  std::uint64_t rays_traced_ = 0, sun_rays_ = 0;
};

/// Outputs of a pass other than its points.
struct PassOutput {
  SlotRadiance& radiance;
  FirstHit& first_hit;
  Statistics& statistics;
};

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

/// Traces the blocks of the tasks, and joins their results in the order of the blocks.
template <typename Join>
void trace_blocks(const Tracer& tracer, const Camera& camera, CameraTasks tasks, const CameraPassSettings& settings,
                  bool as_queries, const PassOutput& output, Join&& join) {
  output.radiance.resize(tasks.slot_count(), !tracer.scene().media().empty());
  output.first_hit.resize(tasks.slot_count(), settings.places);
  if (settings.surface_samples) {
    output.radiance.surface_emitted.resize(tasks.slot_count());
    output.first_hit.surface_albedo.resize(tasks.slot_count());
  }
  const std::vector<Block> blocks = blocks_of(tasks);
  if (settings.segments) settings.segments->clear();
  const auto trace = [&](std::size_t number, BlockMemory& memory) {
    const Block& block = blocks[number];
    BlockTracer block_tracer(tracer, camera, *block.task, block.first_slot, settings, as_queries, output.radiance,
                             output.first_hit, memory);
    block_tracer.trace(block.x, block.y);
    output.statistics.add(Counter::camera_rays, block_tracer.rays_traced());
    if (block_tracer.shadow_rays() > 0) output.statistics.add(Counter::occlusion_rays, block_tracer.shadow_rays());
  };
  make_parts<BlockMemory>(blocks.size(), trace, [&](const BlockMemory& block) {
    join(block);
    if (settings.segments) settings.segments->append(block.segments);
  });
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

void camera_pass(const Tracer& tracer, const Camera& camera, CameraTasks tasks, const CameraPassSettings& settings,
                 SlotRadiance& radiance, FirstHit& first_hit, GatherPoints& points, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::camera_pass);
  points.clear();
  points.reserve(tasks.slot_count());
  trace_blocks(tracer, camera, tasks, settings, false, {radiance, first_hit, statistics},
               [&](const BlockMemory& block) { points.append(block.points); });
  statistics.add(Counter::gather_points, points.size());
}

GatherPoints camera_pass(const Tracer& tracer, const Camera& camera, CameraTasks tasks,
                         const CameraPassSettings& settings, SlotRadiance& radiance, FirstHit& first_hit,
                         Statistics& statistics) {
  GatherPoints points;
  camera_pass(tracer, camera, tasks, settings, radiance, first_hit, points, statistics);
  return points;
}

void camera_pass_queries(const Tracer& tracer, const Camera& camera, CameraTasks tasks,
                         const CameraPassSettings& settings, SlotRadiance& radiance, FirstHit& first_hit,
                         QueryPoints& queries, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::camera_pass);
  queries.clear();
  queries.reserve(tasks.slot_count());
  trace_blocks(tracer, camera, tasks, settings, true, {radiance, first_hit, statistics},
               [&](const BlockMemory& block) { queries.append(block.queries); });
}

}  // namespace glowworm
