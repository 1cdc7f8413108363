#include "render/path_tracer.h"

#include <algorithm>
#include <limits>

#include "core/offset_origin.h"
#include "core/parallel.h"
#include "core/part_queue.h"
#include "core/random.h"
#include "core/roulette.h"
#include "gather/cell_place.h"
#include "gather/direct_light.h"
#include "gather/final_gather.h"
#include "scene/light_sampling.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

constexpr std::size_t kSamplesPerChunk = 256;
/// Samples whose query points are looked up together: these fit the memory of a thread's rays (kBytesPerThread).
constexpr std::size_t kSamplesPerLookup = 4096;
/// Surfaces of the shortest path of a light that photons bring, beyond the one that is looked up.
constexpr int kLeastBent = 1;

/// Bounces of a path so far, as far as they decide the layer of its light.
struct History {
  bool gathered = false;     ///< a broad bounce: the path has passed the gather point
  bool rough_sharp = false;  ///< a sharp bounce that is not a delta, before the gather point
  bool sharp_after_gather = false;
  bool broad_after_gather = false;

  void mark(Lobes lobe, bool delta) {
    if (lobe != kSharp)
      (gathered ? broad_after_gather : gathered) = true;
    else if (gathered)
      sharp_after_gather = true;
    else if (!delta)
      rough_sharp = true;
  }
  std::vector<RGB>& destination(SlotRadiance& radiance) const {
    if (!gathered) return rough_sharp ? radiance.direct : radiance.emitted;
    if (broad_after_gather) return radiance.indirect;
    return sharp_after_gather ? radiance.caustic : radiance.direct;
  }
};

/// Places of paths where photons bring light that the paths do not find.
struct Lookups {
  QueryPoints caustic, indirect;  ///< by the layer of their light; gather_point is the slot
  std::vector<AirPoint> air;

  void clear() {
    caustic.clear();
    indirect.clear();
    air.clear();
  }
  void append(const Lookups& other) {
    caustic.append(other.caustic);
    indirect.append(other.indirect);
    air.insert(air.end(), other.air.begin(), other.air.end());
  }
};

/// One path, from the camera to its end.
class Path {
 public:
  /// @param lookups null: none
  Path(const Tracer& tracer, const RenderSettings& settings, Sampler sampler, std::uint32_t slot,
       SlotRadiance& radiance, FirstHit& first_hit, Lookups* lookups)
      : tracer_(tracer),
        scene_(tracer.scene()),
        settings_(settings),
        sampler_(sampler),
        slot_(slot),
        radiance_(radiance),
        first_hit_(first_hit),
        lookups_(lookups) {}

  /// The light that arrives at the place of a sample of a cell of the grid.
  void trace_from(const PointGrid& grid, std::size_t cell, std::uint32_t sample) {
    mark_point(grid, cell, first_hit_, slot_);
    SurfacePoint point = white_point(scene_, grid, cell);
    point.position = place_in_cell(grid, cell, sample);
    const Bsdf bsdf = white_bsdf();
    throughput_ = RGB(kPi);
    start_ = kPi;
    add_sampled_light(point, bsdf, point.geometric_normal);
    if (lookups_ && !grid.on_surfaces)
      lookups_->air.push_back(air_point(scene_, grid, cell, slot_));
    else
      add_lookup(point, bsdf, point.geometric_normal, 0);
    Ray ray;
    if (scatter(point, shaded(point, bsdf), point.geometric_normal, 0, ray)) trace(ray, 1);
  }

  /// @param first_bounce number of surfaces before
  void trace(Ray ray, int first_bounce = 0) {
    for (int bounce = first_bounce;; ++bounce) {
      const Hit hit = tracer_.intersect(ray, bounce == 0 ? RayOrder::camera : RayOrder::incoherent);
      if (bounce == 0) see(hit);
      if (hit.triangle == kNone) {
        add_light(environment_radiance(scene_, ray.direction), environment_source(scene_, ray.direction),
                  last_pdf_ > 0 ? environment_pdf(scene_, last_position_, {0, 0, 0}, ray.direction) : 0);
        return;
      }
      SurfacePoint point = surface_point(scene_, hit.triangle, hit.barycentric);
      const Vec3 wo = -ray.direction;
      throughput_ *= transmittance(absorption_, absorption(scene_, hit.triangle, wo), hit.distance);
      const RGB emitted = emitted_radiance(scene_, point, wo);
      if (!is_black(emitted))
        add_light(emitted, scene_.emissive_index(hit.triangle),
                  last_pdf_ > 0 ? light_pdf(scene_, last_position_, {0, 0, 0}, point) : 0);
      Bsdf bsdf = resolve_bsdf(scene_, point);
      if (bsdf.dispersion > 0) throughput_ *= choose_wavelength(bsdf, throughput_, sampler_.next1());
      const ShadedSurface surface = shaded(point, bsdf);
      if (bounce == 0) {
        first_hit_.normal[slot_] = shading_normal_towards(point.frame.n, point.geometric_normal, wo);
        first_hit_.albedo[slot_] = surface.albedo(wo, kAllLobes);
      }
      if (bounce >= settings_.max_bounces) return;
      add_sampled_light(point, bsdf, wo);
      add_lookup(point, bsdf, wo, bounce);
      if (!scatter(point, surface, wo, bounce, ray)) return;
    }
  }

  std::uint64_t shadow_rays = 0;

 private:
  void see(const Hit& hit) {
    first_hit_.depth[slot_] = hit.triangle == kNone ? std::numeric_limits<float>::infinity() : hit.distance;
    if (first_hit_.triangle.empty()) return;
    first_hit_.triangle[slot_] = hit.triangle;
    first_hit_.barycentric[slot_] = hit.barycentric;
  }

  void add_light(RGB light, std::uint32_t source, float light_density) {
    const float weight = last_pdf_ > 0 ? balance_heuristic(1, last_pdf_, 1, light_density) : 1.0f;
    radiance_.add(history_.destination(radiance_), slot_, throughput_ * light * weight, source);
  }

  /// Next-event estimation, separately for each kind of lobe, whose light belongs to different layers.
  void add_sampled_light(const SurfacePoint& point, const Bsdf& bsdf, Vec3 wo) {
    const Vec2 pair = sampler_.next2();
    const float u = sampler_.next1();
    if (!takes_light_samples(bsdf)) return;
    const LightSample sample = sample_light(scene_, point.position, {0, 0, 0}, pair.x, {u, pair.y});
    for (const Lobes which : {kBroad, kSharp}) {
      if (!(lobes(bsdf) & which)) continue;
      const UnoccludedLight light = reflected_light(scene_, sample, point, bsdf, wo, which);
      if (is_black(light.radiance)) continue;
      ++shadow_rays;
      const RGB passed = tracer_.transmittance(light.shadow_ray);
      if (is_black(passed)) continue;
      const float weight =
          sample.delta ? 1.0f
                       : balance_heuristic(1, sample.pdf, 1, shaded(point, bsdf).pdf(wo, sample.direction, kAllLobes));
      History with = history_;
      with.mark(which == kSharp ? kSharp : kDiffuseReflection, false);
      radiance_.add(with.destination(radiance_), slot_, throughput_ * light.radiance * passed * weight, light.source);
    }
  }

  void add_lookup(const SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, int bounce) {
    if (!lookups_ || !(lobes(bsdf) & kBroad) || bounce + kLeastBent >= settings_.max_bounces) return;
    add_query(history_.gathered ? lookups_->indirect : lookups_->caustic, point.position,
              face_forward(point.geometric_normal, wo), point.frame, wo, bsdf, throughput_, slot_);
  }

  /// Continues in a direction sampled from the BSDF; false if the path ends.
  bool scatter(const SurfacePoint& point, const ShadedSurface& surface, Vec3 wo, int bounce, Ray& ray) {
    const float u_lobe = sampler_.next1();
    const ScatteredRay s = surface.sample(wo, u_lobe, sampler_.next2(), kAllLobes);
    if (!s.valid) return false;
    throughput_ *= s.weight;
    if (is_black(throughput_)) return false;
    const float probability = survival(max_component(throughput_) / start_, kLeastOfPaths, bounce + 1);
    if (probability < 1) {
      if (sampler_.next1() >= probability) return false;
      throughput_ *= 1 / probability;
    }
    if (!s.straight) {  // shadow rays pass through panes, too
      history_.mark(s.lobe, s.delta);
      last_pdf_ = s.delta ? 0 : s.pdf;
      last_position_ = point.position;
    }
    if (point.triangle != kNone) absorption_ = absorption(scene_, point.triangle, s.direction);
    ray = {offset_origin(point.position, s.side, point.offset), 0, s.direction, std::numeric_limits<float>::infinity()};
    return true;
  }

  const Tracer& tracer_;
  const Scene& scene_;
  const RenderSettings& settings_;
  Sampler sampler_;
  std::uint32_t slot_;
  SlotRadiance& radiance_;
  FirstHit& first_hit_;
  Lookups* lookups_;
  RGB throughput_{1.0f};
  float start_ = 1;       // the throughput before the first bounce
  RGB absorption_{0.0f};  // of the volume that the last bounce led into
  float last_pdf_ = 0;    // of the last bounce; 0 for the camera and deltas, at which no light was sampled
  Vec3 last_position_;
  History history_;
};

/// Traces the samples of tasks.
class PathPass {
 public:
  PathPass(const Tracer& tracer, const View& view, const RenderSettings& settings, const PhotonMaps* maps,
           SlotRadiance& radiance, FirstHit& first_hit, Statistics& statistics)
      : tracer_(tracer),
        view_(view),
        settings_(settings),
        maps_(maps),
        radiance_(radiance),
        first_hit_(first_hit),
        statistics_(statistics) {}

  /// Traces all samples of a task.
  void trace(const CameraTask& task, std::size_t first_slot) {
    const std::size_t at_once = maps_ ? kSamplesPerLookup : task.slot_count();
    for (std::size_t first = 0; first < task.slot_count(); first += at_once) {
      trace(task, first_slot, first, std::min(first + at_once, task.slot_count()));
      if (maps_) look_up();
    }
  }

 private:
  void trace(const CameraTask& task, std::size_t first_slot, std::size_t first, std::size_t last) {
    found_.clear();
    const std::size_t chunks = (last - first + kSamplesPerChunk - 1) / kSamplesPerChunk;
    PartQueue<Lookups> queue(chunks, [&](const Lookups& lookups) { found_.append(lookups); });
    parallel_for(0, chunks, 1, [&](std::size_t, std::size_t) {
      const std::size_t chunk = queue.take(), begin = first + chunk * kSamplesPerChunk;
      const std::size_t end = std::min(begin + kSamplesPerChunk, last);
      std::unique_ptr<Lookups> lookups = queue.borrow();
      lookups->clear();
      std::uint64_t shadow_rays = 0;
      for (std::size_t i = begin; i < end; ++i) shadow_rays += trace_sample(task, first_slot, i, *lookups);
      statistics_.add(Counter::camera_rays, end - begin);
      statistics_.add(Counter::occlusion_rays, shadow_rays);
      queue.put(chunk, std::move(lookups));
    });
  }

  /// Returns the number of shadow rays.
  std::uint64_t trace_sample(const CameraTask& task, std::size_t first_slot, std::size_t in_task, Lookups& lookups) {
    const auto in_tile = static_cast<int>(in_task % task.pixel_count());
    const std::uint32_t sample = task.first_sample + static_cast<std::uint32_t>(in_task / task.pixel_count());
    const int width = task.x1 - task.x0, x = task.x0 + in_tile % width, y = task.y0 + in_tile / width;
    if (!task.has(x, y)) return 0;
    const auto slot = static_cast<std::uint32_t>(first_slot + in_task);
    const auto pixel =
        static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(settings_.width) + static_cast<std::uint32_t>(x);
    const PointGrid* const grid = view_.points;
    Sampler sampler(settings_.sampler, settings_.seed,
                    hash_combine(grid ? grid->sequence(pixel, sample) : pixel, kPathStream),
                    grid ? grid->place_in_sequence(sample) : sample);
    const auto start = [&](const Sampler& rest) {
      return Path(tracer_, settings_, rest, slot, radiance_, first_hit_, maps_ ? &lookups : nullptr);
    };
    if (grid) {
      first_hit_.depth[slot] = std::numeric_limits<float>::infinity();
      if (!grid->has(pixel)) return 0;
      Path path = start(sampler);
      path.trace_from(*grid, pixel, sample);
      return path.shadow_rays;
    }
    const Vec2 u = sampler.next2();
    const CameraRay ray = generate_ray(*view_.camera, {static_cast<float>(x) + u.x, static_cast<float>(y) + u.y},
                                       settings_.width, settings_.height, sampler.next2());
    Path path = start(sampler);
    path.trace({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
    return path.shadow_rays;
  }

  void look_up() {
    look_up(found_.caustic, radiance_.caustic);
    look_up(found_.indirect, radiance_.indirect);
    add_air_light(tracer_, maps_->air(), found_.air, radiance_, radiance_.caustic, statistics_);
  }

  void look_up(const QueryPoints& queries, std::vector<RGB>& target) {
    const PhotonMaps::Engines& engines = maps_->caustic_engines();
    for (std::size_t i = 0; i < engines.size(); ++i) {
      found_light_.assign(queries.size(), RGB());
      engines[i]->estimate(queries, found_light_, statistics_);
      complete(queries, found_light_, target, statistics_);
      if (!radiance_.groups.empty()) complete(queries, found_light_, radiance_.groups[i], statistics_);
    }
  }

  const Tracer& tracer_;
  const View& view_;
  const RenderSettings& settings_;
  const PhotonMaps* maps_;
  SlotRadiance& radiance_;
  FirstHit& first_hit_;
  Statistics& statistics_;
  Lookups found_;
  LargeVector<RGB> found_light_;
};

}  // namespace

void trace_paths(const Tracer& tracer, const View& view, CameraTasks tasks, const RenderSettings& settings,
                 const PhotonMaps* maps, SlotRadiance& radiance, FirstHit& first_hit, Statistics& statistics) {
  radiance.resize(tasks.slot_count());
  first_hit.resize(tasks.slot_count(), settings.place_layers().of_triangles());
  PathPass pass(tracer, view, settings, maps, radiance, first_hit, statistics);
  std::size_t first_slot = 0;
  for (const CameraTask& task : tasks) {
    pass.trace(task, first_slot);
    first_slot += task.slot_count();
  }
}

}  // namespace glowworm
