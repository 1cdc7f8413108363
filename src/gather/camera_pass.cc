#include "gather/camera_pass.h"

#include <limits>

#include "core/parallel.h"
#include "core/random.h"
#include "gather/direct_light.h"
#include "scene/light_sampling.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

/// Pixels are taken in square blocks of this side, so that packets of rays are compact.
constexpr int kBlock = 16;
/// Sharp bounces after which Russian roulette sets in.
constexpr int kRouletteAfter = 4;

/// Camera paths of one block, in structure-of-arrays form.
struct CameraPaths {
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<RGB> throughput;
  std::vector<Sampler> samplers;
  std::vector<std::uint32_t> slot, sequence, sample;
  /// Density of the last bounce per steradian, and where it was: 0 for the camera and perfectly smooth bounces, at
  /// which no light was sampled.
  std::vector<float> bounce_pdf;
  std::vector<Vec3> bounce_position;

  void reserve(std::size_t n) {
    rays.reserve(n);
    hits.reserve(n);
    throughput.reserve(n);
    samplers.reserve(n);
    slot.reserve(n);
    sequence.reserve(n);
    sample.reserve(n);
    bounce_pdf.reserve(n);
    bounce_position.reserve(n);
  }
  void move(std::size_t from, std::size_t to) {
    if (from == to) return;
    rays[to] = rays[from];
    throughput[to] = throughput[from];
    samplers[to] = samplers[from];
    slot[to] = slot[from];
    sequence[to] = sequence[from];
    sample[to] = sample[from];
    bounce_pdf[to] = bounce_pdf[from];
    bounce_position[to] = bounce_position[from];
  }
  void shrink(std::size_t n) {
    rays.resize(n);
    throughput.resize(n);
    samplers.erase(samplers.begin() + static_cast<std::ptrdiff_t>(n), samplers.end());
    slot.resize(n);
    sequence.resize(n);
    sample.resize(n);
    bounce_pdf.resize(n);
    bounce_position.resize(n);
  }
};

class BlockTracer {
 public:
  BlockTracer(const Tracer& tracer, const Camera& camera, const CameraTask& task, const CameraPassSettings& settings,
              SlotRadiance& radiance, FirstHit& first_hit)
      : tracer_(tracer),
        camera_(camera),
        task_(task),
        settings_(settings),
        radiance_(radiance),
        first_hit_(first_hit) {}

  GatherPoints trace(int x0, int y0) {
    start(x0, y0);
    for (int bounce = 0; !paths_.rays.empty(); ++bounce) {
      paths_.hits.resize(paths_.rays.size());
      tracer_.intersect(paths_.rays, paths_.hits, bounce == 0 ? RayOrder::coherent : RayOrder::incoherent);
      rays_traced_ += paths_.rays.size();
      std::size_t kept = 0;
      for (std::size_t i = 0; i < paths_.rays.size(); ++i)
        if (advance(i, bounce)) paths_.move(i, kept++);
      paths_.shrink(kept);
    }
    return std::move(points_);
  }
  std::uint64_t rays_traced() const { return rays_traced_; }

 private:
  void start(int x0, int y0) {
    const int width = task_.x1 - task_.x0;
    const std::size_t most = std::size_t{kBlock} * kBlock * task_.sample_count;
    paths_.reserve(most);
    points_.reserve(most);
    for (std::uint32_t s = 0; s < task_.sample_count; ++s)
      for (int y = y0; y < std::min(y0 + kBlock, task_.y1); ++y)
        for (int x = x0; x < std::min(x0 + kBlock, task_.x1); ++x) {
          const auto pixel = static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(settings_.width) +
                             static_cast<std::uint32_t>(x);
          const std::uint32_t sample = task_.first_sample + s;
          Sampler sampler(SamplerKind::sobol, settings_.seed, hash_combine(pixel, 0x63616d65u), sample);
          const Vec2 u = sampler.next2();
          const Vec2 film{static_cast<float>(x) + u.x, static_cast<float>(y) + u.y};
          const CameraRay ray = generate_ray(camera_, film, settings_.width, settings_.height, sampler.next2());
          paths_.rays.push_back({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
          paths_.throughput.push_back(RGB(1.0f));
          paths_.samplers.push_back(sampler);
          paths_.slot.push_back(static_cast<std::uint32_t>(
              s * task_.pixel_count() + static_cast<std::size_t>((y - task_.y0) * width + (x - task_.x0))));
          paths_.sequence.push_back(pixel);
          paths_.sample.push_back(sample);
          paths_.bounce_pdf.push_back(0);
          paths_.bounce_position.push_back({});
        }
  }

  /// Takes path i over its hit; true where it goes on through a sharp bounce.
  bool advance(std::size_t i, int bounce) {
    const Scene& scene = tracer_.scene();
    const Hit& hit = paths_.hits[i];
    const std::uint32_t slot = paths_.slot[i];
    const Vec3 direction = paths_.rays[i].direction;
    if (bounce == 0)
      first_hit_.depth[slot] = hit.triangle == kNone ? std::numeric_limits<float>::infinity() : hit.distance;
    if (hit.triangle == kNone) {
      const RGB sky = environment_radiance(scene, direction);
      float weight = 1;
      if (paths_.bounce_pdf[i] > 0)
        weight = balance_heuristic(1, paths_.bounce_pdf[i], 1,
                                   environment_pdf(scene, paths_.bounce_position[i], {0, 0, 0}, direction));
      radiance_.emitted[slot] += paths_.throughput[i] * sky * weight;
      return false;
    }
    SurfacePoint point = surface_point(scene, hit.triangle, hit.barycentric);
    const Vec3 wo = -direction;
    add_emission(i, point, wo);
    const Bsdf bsdf = resolve_bsdf(scene, point, wo);
    const Lobes have = lobes(bsdf);
    Sampler& sampler = paths_.samplers[i];
    if (bounce == 0) first_hit_.normal[slot] = face_forward(point.frame.n, wo);
    if (bounce == 0) first_hit_.albedo[slot] = albedo(bsdf, point.frame.to_local(wo), kAllLobes);
    float broad_probability = have & kBroad ? 1.0f : 0.0f;
    if ((have & kBroad) && (have & kSharp)) {
      const Vec3 wo_local = point.frame.to_local(wo);
      const float broad = luminance(albedo(bsdf, wo_local, kBroad));
      const float sharp = luminance(albedo(bsdf, wo_local, kSharp));
      broad_probability = broad + sharp > 0 ? broad / (broad + sharp) : 1;
    }
    if (broad_probability >= 1 || sampler.next1() < broad_probability) {
      add_gather_point(i, point, bsdf, wo, paths_.throughput[i] / broad_probability);
      return false;
    }
    paths_.throughput[i] *= 1 / (1 - broad_probability);
    return bounce < settings_.max_sharp_bounces && follow(i, point, bsdf, wo, bounce);
  }

  void add_emission(std::size_t i, const SurfacePoint& point, Vec3 wo) {
    const RGB emitted = emitted_radiance(tracer_.scene(), point, wo);
    if (is_black(emitted)) return;
    float weight = 1;
    if (paths_.bounce_pdf[i] > 0)
      weight = balance_heuristic(1, paths_.bounce_pdf[i], 1,
                                 light_pdf(tracer_.scene(), paths_.bounce_position[i], {0, 0, 0}, point));
    radiance_.emitted[paths_.slot[i]] += paths_.throughput[i] * emitted * weight;
  }

  void add_gather_point(std::size_t i, const SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, RGB throughput) {
    points_.slot.push_back(paths_.slot[i]);
    points_.sequence.push_back(paths_.sequence[i]);
    points_.sample.push_back(paths_.sample[i]);
    points_.position.push_back(point.position);
    points_.normal.push_back(face_forward(point.geometric_normal, wo));
    points_.frame.push_back(point.frame);
    points_.wo.push_back(wo);
    points_.bsdf.push_back(bsdf);
    points_.throughput.push_back(throughput);
  }

  /// Goes on through the sharp lobes of the surface; adds what rough ones reflect of the lights.
  bool follow(std::size_t i, const SurfacePoint& point, const Bsdf& bsdf, Vec3 wo, int bounce) {
    Sampler& sampler = paths_.samplers[i];
    const float u_lobe = sampler.next1();
    const BsdfSample s = sample(bsdf, point.frame.to_local(wo), u_lobe, sampler.next2(), kSharp, Transport::radiance);
    const Vec2 u_light = sampler.next2();
    const UnoccludedLight light =
        sample_direct_light(tracer_.scene(), point, bsdf, wo, kSharp, u_light.x, {sampler.next1(), u_light.y}, 1, 1);
    if (!is_black(light.radiance) && !tracer_.occluded(light.shadow_ray))
      radiance_.direct[paths_.slot[i]] += paths_.throughput[i] * light.radiance;
    if (!s.valid) return false;
    const Vec3 direction = point.frame.to_world(s.wi);
    const float side = dot(direction, point.geometric_normal);
    if ((side * dot(wo, point.geometric_normal) > 0) != (s.wi.z * dot(wo, point.frame.n) > 0)) return false;
    RGB throughput = paths_.throughput[i] * s.weight;
    if (bounce >= kRouletteAfter) {
      const float survival = std::min(0.95f, max_component(throughput));
      if (!(survival > 0) || sampler.next1() >= survival) return false;
      throughput *= 1 / survival;
    }
    if (is_black(throughput)) return false;
    paths_.throughput[i] = throughput;
    paths_.bounce_pdf[i] = s.delta ? 0 : s.pdf;
    paths_.bounce_position[i] = point.position;
    const Vec3 normal = side > 0 ? point.geometric_normal : -point.geometric_normal;
    paths_.rays[i] = {offset_origin(point.position, normal), 0, direction, std::numeric_limits<float>::infinity()};
    return true;
  }

  const Tracer& tracer_;
  const Camera& camera_;
  const CameraTask& task_;
  const CameraPassSettings& settings_;
  SlotRadiance& radiance_;
  FirstHit& first_hit_;
  CameraPaths paths_;
  GatherPoints points_;
  std::uint64_t rays_traced_ = 0;
};

}  // namespace

GatherPoints camera_pass(const Tracer& tracer, const Camera& camera, const CameraTask& task,
                         const CameraPassSettings& settings, SlotRadiance& radiance, FirstHit& first_hit,
                         Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::camera_pass);
  radiance.resize(task.slot_count());
  first_hit.albedo.assign(task.slot_count(), RGB());
  first_hit.normal.assign(task.slot_count(), Vec3());
  first_hit.depth.assign(task.slot_count(), 0);
  const int columns = (task.x1 - task.x0 + kBlock - 1) / kBlock, rows = (task.y1 - task.y0 + kBlock - 1) / kBlock;
  const auto blocks = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  std::vector<GatherPoints> parts(blocks);
  parallel_for(0, blocks, 1, [&](std::size_t block, std::size_t) {
    BlockTracer block_tracer(tracer, camera, task, settings, radiance, first_hit);
    parts[block] = block_tracer.trace(task.x0 + static_cast<int>(block) % columns * kBlock,
                                      task.y0 + static_cast<int>(block) / columns * kBlock);
    statistics.add(Counter::camera_rays, block_tracer.rays_traced());
  });
  GatherPoints points;
  points.append(parts);
  statistics.add(Counter::gather_points, points.size());
  return points;
}

}  // namespace glowworm
