#include "render/path_tracer.h"

#include <algorithm>
#include <limits>

#include "core/offset_origin.h"
#include "core/parallel.h"
#include "core/random.h"
#include "gather/cell_place.h"
#include "gather/direct_light.h"
#include "scene/light_sampling.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

constexpr std::size_t kSamplesPerChunk = 256;
constexpr int kRouletteAfter = 3;

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

/// One path, from the camera to its end.
class Path {
 public:
  Path(const Tracer& tracer, const RenderSettings& settings, Sampler sampler, std::uint32_t slot,
       SlotRadiance& radiance, FirstHit& first_hit)
      : tracer_(tracer),
        scene_(tracer.scene()),
        settings_(settings),
        sampler_(sampler),
        slot_(slot),
        radiance_(radiance),
        first_hit_(first_hit) {}

  /// The light that arrives at the place of a sample of a cell of the grid.
  void trace_from(const PointGrid& grid, std::size_t cell, std::uint32_t sample) {
    mark_point(grid, cell, first_hit_, slot_);
    SurfacePoint point = white_point(scene_, grid, cell);
    point.position = place_in_cell(grid, cell, sample);
    const Bsdf bsdf = white_bsdf();
    throughput_ = RGB(kPi);
    add_sampled_light(point, bsdf, point.geometric_normal);
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
    const LightSample sample = sample_light(scene_, point.position, {0, 0, 0}, pair.x, {sampler_.next1(), pair.y});
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

  /// Continues in a direction sampled from the BSDF; false if the path ends.
  bool scatter(const SurfacePoint& point, const ShadedSurface& surface, Vec3 wo, int bounce, Ray& ray) {
    const float u_lobe = sampler_.next1();
    const ScatteredRay s = surface.sample(wo, u_lobe, sampler_.next2(), kAllLobes);
    if (!s.valid) return false;
    throughput_ *= s.weight;
    if (is_black(throughput_)) return false;
    if (bounce >= kRouletteAfter) {
      const float survival = std::min(0.95f, max_component(throughput_));
      if (sampler_.next1() >= survival) return false;
      throughput_ *= 1 / survival;
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
  RGB throughput_{1.0f};
  RGB absorption_{0.0f};  // of the volume that the last bounce led into
  float last_pdf_ = 0;    // of the last bounce; 0 for the camera and deltas, at which no light was sampled
  Vec3 last_position_;
  History history_;
};

}  // namespace

void trace_paths(const Tracer& tracer, const View& view, CameraTasks tasks, const RenderSettings& settings,
                 SlotRadiance& radiance, FirstHit& first_hit, Statistics& statistics) {
  radiance.resize(tasks.slot_count());
  first_hit.resize(tasks.slot_count(), settings.place_layers().of_triangles());
  std::size_t first_slot = 0;
  const auto trace = [&](const CameraTask& task, std::size_t in_task) -> std::uint64_t {
    const auto in_tile = static_cast<int>(in_task % task.pixel_count());
    const std::uint32_t sample = task.first_sample + static_cast<std::uint32_t>(in_task / task.pixel_count());
    const int width = task.x1 - task.x0, x = task.x0 + in_tile % width, y = task.y0 + in_tile / width;
    if (!task.has(x, y)) return 0;
    const std::size_t slot = first_slot + in_task;
    const auto pixel =
        static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(settings.width) + static_cast<std::uint32_t>(x);
    const PointGrid* const grid = view.points;
    Sampler sampler(settings.sampler, settings.seed,
                    hash_combine(grid ? grid->sequence(pixel, sample) : pixel, kPathStream),
                    grid ? grid->place_in_sequence(sample) : sample);
    const auto start = [&](const Sampler& rest) {
      return Path(tracer, settings, rest, static_cast<std::uint32_t>(slot), radiance, first_hit);
    };
    if (grid) {
      first_hit.depth[slot] = std::numeric_limits<float>::infinity();
      if (!grid->has(pixel)) return 0;
      Path path = start(sampler);
      path.trace_from(*grid, pixel, sample);
      return path.shadow_rays;
    }
    const Vec2 u = sampler.next2();
    const CameraRay ray = generate_ray(*view.camera, {static_cast<float>(x) + u.x, static_cast<float>(y) + u.y},
                                       settings.width, settings.height, sampler.next2());
    Path path = start(sampler);
    path.trace({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
    return path.shadow_rays;
  };
  for (const CameraTask& task : tasks) {
    parallel_for(0, task.slot_count(), kSamplesPerChunk, [&](std::size_t first, std::size_t last) {
      std::uint64_t shadow_rays = 0;
      for (std::size_t i = first; i < last; ++i) shadow_rays += trace(task, i);
      statistics.add(Counter::camera_rays, last - first);
      statistics.add(Counter::occlusion_rays, shadow_rays);
    });
    first_slot += task.slot_count();
  }
}

}  // namespace glowworm
