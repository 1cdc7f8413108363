#include "gather/camera_pass.h"

#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "core/part_queue.h"
#include "core/random.h"
#include "gather/final_gather.h"
#include "kernels/sobol.h"
#include "scene/surface.h"
#include "transport/light_connection.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// Pixels are traced in square blocks of this side, so that packets of rays are compact. Blocks are aligned to the
/// whole picture, not to the task, because a hit's last bits depend on the ray's packet.
constexpr int kBlock = CameraTask::kBlock;
/// Within a block, pixels are grouped in squares of this side, which fill a packet.
constexpr int kSquare = CameraTask::kSquare;
/// Slot of a camera ray that only fills a packet; its pixel is not of the task.
constexpr std::uint32_t kNoSlot = 0xffffffffu;
/// Up to this many bounces, surface samples follow both reflection and refraction by clear glass. With a random choice,
/// a lamp that is rarely chosen would make single bright pixels.
constexpr int kSplitBounces = 4;

/// State of a camera path between bounces.
struct CameraPath : PathState {
  Sampler sampler;
  std::uint32_t slot, sequence, sample;
};

/// Working memory, reused for one block after another.
struct BlockMemory {
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<std::uint32_t> slot, pixel;  // of the camera rays
  std::vector<CameraPath> paths;           // paths that continue through a sharp bounce
  std::vector<CameraPath> split_paths;     // of surface samples that continue on a second path
  GatherPoints points;                     // the one or the other
  QueryPoints queries;
  std::vector<std::uint32_t> stream;  // streams of random numbers of the points that follow
  std::vector<float> film_x, film_y, lens_x, lens_y;
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
        rays_(memory.rays),
        hits_(memory.hits),
        slot_(memory.slot),
        pixel_(memory.pixel),
        paths_(memory.paths),
        points_(memory.points),
        queries_(memory.queries) {}

  void trace(int x0, int y0) {
    points_.clear();
    queries_.clear();
    follow_paths(x0, y0);
    if (!settings_.fine) return;
    for (surface_sample_ = 0; surface_sample_ < static_cast<int>(kSurfaceSamples); ++surface_sample_)
      follow_paths(x0, y0);
  }
  std::uint64_t rays_traced() const { return rays_traced_; }

 private:
  void follow_paths(int x0, int y0) {
    paths_.clear();
    start(x0, y0);
    intersect_camera_rays();
    for (std::size_t i = 0; i < slot_.size(); ++i) see(i);
    keep_paths(paths_.size());
    for (int bounce = 1; !rays_.empty(); ++bounce) {
      intersect();
      std::size_t kept = 0;
      for (std::size_t i = 0; i < rays_.size(); ++i)
        if (advance(paths_[i], hits_[i], bounce)) paths_[kept++] = paths_[i];
      keep_paths(kept);
    }
  }

  /// Keeps that many paths, and adds those that were split off.
  void keep_paths(std::size_t kept) {
    paths_.erase(paths_.begin() + static_cast<std::ptrdiff_t>(kept), paths_.end());
    paths_.insert(paths_.end(), memory_.split_paths.begin(), memory_.split_paths.end());
    rays_.clear();
    for (const CameraPath& path : paths_) rays_.push_back(path.ray);
    memory_.split_paths.clear();
  }

  void start(int x0, int y0) {
    rays_.clear();
    slot_.clear();
    pixel_.clear();
    const int x1 = std::min(x0 + kBlock, settings_.width), y1 = std::min(y0 + kBlock, settings_.height);
    for (std::uint32_t s = 0; s < task_.sample_count; ++s) {
      const std::size_t first = slot_.size();
      for (int y = y0; y < y1; y += kSquare)
        for (int x = x0; x < x1; x += kSquare)
          add_square(s, x, y, std::min(x + kSquare, x1), std::min(y + kSquare, y1));
      create_rays(first, task_.first_sample + s);
    }
  }

  /// Lists the pixels of a square together, so that the rays of a packet are close together.
  void add_square(std::uint32_t s, int x0, int y0, int x1, int y1) {
    const int width = task_.x1 - task_.x0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        const bool inside = x >= task_.x0 && x < task_.x1 && y >= task_.y0 && y < task_.y1 && task_.has(x, y);
        const auto in_tile = static_cast<std::size_t>((y - task_.y0) * width + (x - task_.x0));
        slot_.push_back(inside ? static_cast<std::uint32_t>(first_slot_ + s * task_.pixel_count() + in_tile) : kNoSlot);
        pixel_.push_back(static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(settings_.width) +
                         static_cast<std::uint32_t>(x));
      }
  }

  /// Makes rays through the block's pixels from index `first` on.
  void create_rays(std::size_t first, std::uint32_t sample) {
    const std::size_t n = pixel_.size() - first;
    memory_.stream.resize(n);
    for (auto* numbers : {&memory_.film_x, &memory_.film_y, &memory_.lens_x, &memory_.lens_y}) numbers->resize(n);
    for (std::size_t i = 0; i < n; ++i) memory_.stream[i] = stream_of(pixel_[first + i]);
    sobol_pairs_of(settings_.seed, memory_.stream.data(), n, in_stream(sample), 0, memory_.film_x.data(),
                   memory_.film_y.data());
    const bool has_lens = camera_.lens_radius > 0;
    if (has_lens)
      sobol_pairs_of(settings_.seed, memory_.stream.data(), n, in_stream(sample), 1, memory_.lens_x.data(),
                     memory_.lens_y.data());
    const auto width = static_cast<std::uint32_t>(settings_.width);
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t pixel = pixel_[first + i];
      const Vec2 film{static_cast<float>(pixel % width) + memory_.film_x[i],
                      static_cast<float>(pixel / width) + memory_.film_y[i]};
      const Vec2 lens = has_lens ? Vec2{memory_.lens_x[i], memory_.lens_y[i]} : Vec2();
      const CameraRay ray = generate_ray(camera_, film, settings_.width, settings_.height, lens);
      rays_.push_back({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
    }
  }

  bool is_surface_sample() const { return surface_sample_ >= 0; }
  /// The sequence of random numbers of a pixel.
  std::uint32_t stream_of(std::uint32_t pixel) const {
    return hash_combine(pixel, is_surface_sample() ? kSurfaceStream : kCameraStream);
  }
  /// The place of a camera sample in its sequence.
  std::uint32_t in_stream(std::uint32_t sample) const {
    return is_surface_sample() ? sample * kSurfaceSamples + static_cast<std::uint32_t>(surface_sample_) : sample;
  }

  void intersect() {
    hits_.resize(rays_.size());
    tracer_.intersect(rays_, hits_, RayOrder::incoherent);
    rays_traced_ += rays_.size();
  }

  /// Traces one sample after another: the number of samples of the task must not change which rays share a packet,
  /// because the last bits of a coherent ray's hit depend on that.
  void intersect_camera_rays() {
    hits_.resize(rays_.size());
    const std::size_t each = rays_.size() / task_.sample_count;
    for (std::size_t first = 0; first < rays_.size(); first += each)
      tracer_.intersect(std::span(rays_).subspan(first, each), std::span(hits_).subspan(first, each), RayOrder::camera);
    rays_traced_ += rays_.size();
  }

  /// Processes the hit of camera ray i. Appends its path if it continues.
  void see(std::size_t i) {
    if (slot_[i] == kNoSlot) return;
    const Hit& hit = hits_[i];
    if (is_surface_sample() ? hit.triangle != kNone && look_at_diffuse(i) : see_first(i)) return;
    const std::size_t per_sample = slot_.size() / task_.sample_count;
    const std::uint32_t sample = task_.first_sample + static_cast<std::uint32_t>(i / per_sample);
    Sampler sampler(SamplerKind::sobol, settings_.seed, stream_of(pixel_[i]), in_stream(sample));
    // Film and lens have used the first two pairs.
    for (int taken = 0; taken < 2; ++taken) (void)sampler.next2();
    paths_.push_back({{rays_[i]}, sampler, slot_[i], pixel_[i], sample});
    if (!advance(paths_.back(), hit, 0)) paths_.pop_back();
  }

  /// Records the first hit of camera ray i. Returns true if the path ends there.
  bool see_first(std::size_t i) {
    const Hit& hit = hits_[i];
    first_hit_.depth[slot_[i]] = hit.triangle == kNone ? std::numeric_limits<float>::infinity() : hit.distance;
    if (settings_.places) {
      first_hit_.triangle[slot_[i]] = hit.triangle;
      first_hit_.barycentric[slot_[i]] = hit.barycentric;
    }
    return as_queries_ && hit.triangle != kNone && see_diffuse(i);
  }

  /// A fast version of advance() for surface samples that meet surfaces that only reflect diffusely. Returns false for
  /// other surfaces.
  bool look_at_diffuse(std::size_t i) {
    const Hit& hit = hits_[i];
    DiffusePoint point;
    if (tracer_.scene().geometry().emission[hit.triangle] != kNone ||
        !diffuse_point(tracer_.scene(), hit.triangle, hit.barycentric, point))
      return false;
    add_fine(first_hit_.fine_albedo, slot_[i], point.reflectance);
    return true;
  }

  static void add_fine(std::vector<RGB>& target, std::uint32_t slot, RGB value) {
    target[slot] += value * (1.0f / kSurfaceSamples);
  }

  /// A fast version of advance() for surfaces that only reflect diffusely. Returns false for other surfaces.
  bool see_diffuse(std::size_t i) {
    const Scene& scene = tracer_.scene();
    const Hit& hit = hits_[i];
    const Vec3 wo = -rays_[i].direction;
    DiffusePoint point;
    Vec3 shading_normal;
    if (scene.geometry().emission[hit.triangle] != kNone ||
        !diffuse_point(scene, hit.triangle, hit.barycentric, point) ||
        !diffuse_shading_normal(scene, hit.triangle, hit.barycentric, point, shading_normal))
      return false;
    first_hit_.normal[slot_[i]] = shading_normal_towards(shading_normal, point.geometric_normal, wo);
    first_hit_.albedo[slot_[i]] = point.reflectance;
    if (max_component(point.reflectance) > 0)
      queries_.push_back(point.position, face_forward(point.geometric_normal, wo), point.reflectance, RGB(1.0f),
                         slot_[i]);
    return true;
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

  /// Processes a path's hit. Returns true if the path continues through a sharp bounce.
  bool advance(CameraPath& path, const Hit& hit, int bounce) {
    const Scene& scene = tracer_.scene();
    if (hit.triangle != kNone) path.throughput *= transmittance(scene, path.medium, path.ray, hit);
    return meet(scene, path, hit, Policy{*this, path, bounce});
  }

  bool scatter(CameraPath& path, const Vertex& vertex, int bounce) {
    if (bounce == 0) record_surface(path, vertex);
    // Surface samples see light through the sharp lobes alone.
    if (is_surface_sample()) return vertex.has(kSharp) && follow_surface_sample(path, vertex, bounce);
    const float broad = broad_probability(vertex);
    if (broad >= 1 || path.sampler.next1() < broad) {
      add_point(path, vertex, path.throughput / broad);
      return false;
    }
    path.throughput *= 1 / (1 - broad);
    return follow(path, vertex, bounce);
  }

  void record_surface(const CameraPath& path, const Vertex& vertex) {
    const RGB albedo = vertex.surface().albedo(vertex.wo, kAllLobes);
    if (is_surface_sample()) {
      add_fine(first_hit_.fine_albedo, path.slot, albedo);
      return;
    }
    first_hit_.normal[path.slot] =
        shading_normal_towards(vertex.point.frame.n, vertex.point.geometric_normal, vertex.wo);
    first_hit_.albedo[path.slot] = albedo;
  }

  void add_emitted(std::uint32_t slot, RGB light, std::uint32_t source) {
    if (is_surface_sample())
      add_fine(radiance_.fine_emitted, slot, light);
    else
      radiance_.add(radiance_.emitted, slot, light, source);
  }

  void add_point(const CameraPath& path, const Vertex& vertex, RGB throughput) {
    if (as_queries_) {
      add_query(queries_, vertex, throughput, path.slot);
      return;
    }
    points_.slot.push_back(path.slot);
    points_.sequence.push_back(path.sequence);
    points_.sample.push_back(path.sample);
    points_.position.push_back(vertex.point.position);
    points_.normal.push_back(vertex.normal());
    points_.offset.push_back(vertex.point.offset);
    points_.frame.push_back(vertex.point.frame);
    points_.wo.push_back(vertex.wo);
    points_.bsdf.push_back(vertex.bsdf);
    points_.throughput.push_back(throughput);
  }

  /// Continues through the sharp lobes of the surface, and adds the light of lamps that rough ones reflect.
  bool follow(CameraPath& path, const Vertex& vertex, int bounce) {
    Sampler& sampler = path.sampler;
    const Scene& scene = tracer_.scene();
    const float u_lobe = sampler.next1();
    const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, sampler.next2(), kSharp);
    const Vec2 u_light = sampler.next2();
    const Vec2 u{sampler.next1(), u_light.y};
    if (takes_light_samples(vertex.bsdf)) {
      const LightSample sample = sample_light(scene, vertex.point.position, u_light.x, u);
      const UnoccludedLight light = reflected_light(scene, sample, vertex, kSharp, 1, 1,
                                                    [&](Vec3 w) { return vertex.surface().pdf(vertex.wo, w, kSharp); });
      if (!is_black(light.radiance))
        radiance_.add(radiance_.direct, path.slot,
                      path.throughput * light.radiance * tracer_.transmittance(light.shadow_ray), light.source);
    }
    return leave(scene, path, vertex, s, s.weight) &&
           survives(path, max_component(path.throughput), kLeastOfChains, bounce);
  }

  /// Continues through the sharp lobes, for lamps that are seen through them.
  bool follow_surface_sample(CameraPath& path, const Vertex& vertex, int bounce) {
    const Scene& scene = tracer_.scene();
    const ShadedSurface surface = vertex.surface();
    const float u_lobe = path.sampler.next1();
    const Vec2 u = path.sampler.next2();
    if (bounce < kSplitBounces) {
      constexpr float kAlmostOne = 0x1.fffffep-1f;
      const ScatteredRay first = surface.sample(vertex.wo, 0, u, kSharp),
                         last = surface.sample(vertex.wo, kAlmostOne, u, kSharp);
      // Both lobes are perfectly smooth, and there are no others.
      if (first.valid && last.valid && first.delta && last.delta && std::abs(first.pdf + last.pdf - 1) < 1e-5f) {
        memory_.split_paths.push_back(path);
        if (!leave(scene, memory_.split_paths.back(), vertex, last, last.weight * last.pdf))
          memory_.split_paths.pop_back();
        return leave(scene, path, vertex, first, first.weight * first.pdf);
      }
    }
    const ScatteredRay s = surface.sample(vertex.wo, u_lobe, u, kSharp);
    // Not by throughput: that of split paths is small, and would end them. The first bounces are not left to chance.
    return leave(scene, path, vertex, s, s.weight) &&
           (bounce < kSplitBounces || survives(path, max_component(s.weight), 1, bounce));
  }

  static bool survives(CameraPath& path, float weight, float least, int bounce) {
    const float probability = roulette(weight, least, bounce + 1, [&] { return path.sampler.next1(); });
    if (!(probability > 0)) return false;
    path.throughput *= 1 / probability;
    return true;
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
  std::vector<Ray>& rays_;
  std::vector<Hit>& hits_;
  std::vector<std::uint32_t>&slot_, &pixel_;
  std::vector<CameraPath>& paths_;
  GatherPoints& points_;
  QueryPoints& queries_;
  std::uint64_t rays_traced_ = 0;
  int surface_sample_ = -1;  ///< number of the surface sample; negative: a camera sample that makes gather points
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
  output.radiance.resize(tasks.slot_count());
  output.first_hit.resize(tasks.slot_count(), settings.places);
  if (settings.fine) {
    output.radiance.fine_emitted.resize(tasks.slot_count());
    output.first_hit.fine_albedo.resize(tasks.slot_count());
  }
  const std::vector<Block> blocks = blocks_of(tasks);
  PartQueue<BlockMemory> queue(blocks.size(), join);
  parallel_for(0, blocks.size(), 1, [&](std::size_t, std::size_t) {
    const std::size_t next = queue.take();
    const Block& block = blocks[next];
    std::unique_ptr<BlockMemory> memory = queue.borrow();
    BlockTracer block_tracer(tracer, camera, *block.task, block.first_slot, settings, as_queries, output.radiance,
                             output.first_hit, *memory);
    block_tracer.trace(block.x, block.y);
    output.statistics.add(Counter::camera_rays, block_tracer.rays_traced());
    queue.put(next, std::move(memory));
  });
}

}  // namespace

void FirstHit::resize(std::size_t slots, bool places) {
  albedo.assign(slots, RGB());
  fine_albedo.clear();
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
