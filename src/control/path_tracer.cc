#include "control/path_tracer.h"

#include <algorithm>
#include <limits>

#include "core/make_parts.h"
#include "core/random.h"
#include "gather/final_gather.h"
#include "maps/image_light.h"
#include "scene/surface.h"
#include "transport/light_connection.h"
#include "transport/segment_light.h"
#include "transport/step.h"
#include "transport/vertex.h"

namespace glowworm {

namespace {

constexpr std::size_t kSamplesPerChunk = 256;

/// Bounces of a path so far, as far as they decide the layer of its light.
struct History {
  bool gathered = false;        ///< a broad bounce: the path has passed the gather point
  bool rough_specular = false;  ///< a specular bounce that is not a delta, before the gather point
  bool specular_after_gather = false;
  bool broad_after_gather = false;
  bool in_medium = false;  ///< before the gather point

  /// A medium scatters or emits the path's light.
  void mark_medium() { (gathered ? broad_after_gather : in_medium) = true; }
  void mark(Lobes lobe, bool delta) {
    if (lobe != kSpecular)
      (gathered ? broad_after_gather : gathered) = true;
    else if (gathered)
      specular_after_gather = true;
    else if (!delta)
      rough_specular = true;
  }
  std::vector<RGB>& destination(SlotRadiance& radiance) const {
    if (in_medium) return radiance.medium;
    if (!gathered) return rough_specular ? radiance.direct : radiance.emitted;
    if (broad_after_gather) return radiance.indirect;
    return specular_after_gather ? radiance.caustic : radiance.direct;
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
        lookups_(lookups),
        crosses_media_(scene_.crosses_media()) {}

  /// The light that arrives at the place of a sample of a cell of the grid.
  void trace_from(const PointGrid& grid, std::size_t cell, std::uint32_t sample) {
    mark_point(grid, cell, first_hit_, slot_);
    const Vertex vertex = white_vertex(tracer_, grid, cell, sample);
    state_.throughput = RGB(kPi);
    start_ = kPi;
    add_sampled_light(vertex);
    if (lookups_ && !grid.on_surfaces)
      lookups_->air.push_back(air_point(scene_, grid, cell, slot_));
    else
      add_lookup(vertex);
    if (go_on(vertex)) follow(1);
  }

  void trace_from(const CameraRay& camera, PathMedium medium) {
    state_.ray = {camera.origin, 0, camera.direction, std::numeric_limits<float>::infinity()};
    state_.medium = medium;
    start_at_ = camera.origin;
    follow(0);
  }

  std::uint64_t shadow_rays = 0;

  // What the path does on its step.
  bool finds_light() const { return true; }
  template <typename Density>
  void add_light(RGB light, std::uint32_t source, Density&& density) {
    float weight = weight_of_met_light(state_, density);
    if (segment_.samples() && state_.pdf > 0) {
      const float by_segment = segment_.ratio(scene_, source, on_segment_, met_at_);
      weight = balance_heuristic(1, state_.pdf, 1, density(state_.scattered_at) * (1 + by_segment));
    }
    radiance_.add(history_.destination(radiance_), slot_, state_.throughput * light * weight, source);
  }
  float wavelength_number() { return sampler_.next1(); }
  bool scatter(const Vertex& vertex) {
    if (bounce_ == 0) {
      first_hit_.normal[slot_] = shading_normal_towards(vertex.point.frame.n, vertex.point.geometric_normal, vertex.wo);
      first_hit_.albedo[slot_] = vertex.surface().albedo(vertex.wo, kAllLobes);
    }
    if (bounce_ >= settings_.max_bounces) return false;
    add_sampled_light(vertex);
    add_lookup(vertex);
    return go_on(vertex);
  }

 private:
  /// What a straight part of the path ends at.
  enum class End : std::uint8_t { surface, scattering, nothing };

  /// @param first_bounce number of surfaces before
  void follow(int first_bounce) {
    bounce_ = first_bounce;
    bool goes_on = true;
    while (goes_on) {
      Hit hit = tracer_.intersect(state_.ray, order());
      const End end = crosses_media_ ? cross(hit) : End::surface;
      if (bounce_ == 0 && !history_.in_medium) see(hit);
      goes_on = end == End::surface ? meet(scene_, state_, hit, *this) : end == End::scattering;
      ++bounce_;
    }
  }
  RayOrder order() const { return bounce_ == 0 ? RayOrder::camera : RayOrder::incoherent; }

  /// Takes the path through media to the next surface, or to where it scatters on the way.
  End cross(Hit& hit) {
    bool scatters = false;
    const bool arrives = travel(tracer_, state_, hit, order(), [&](const Medium* inside, float length) {
      if (!inside) return true;
      const Medium& medium = *inside;
      const LitSegment segment(medium, state_, length);
      add_segment_light(segment);
      const MediumSample sample = sample_medium(medium, state_.ray, length, state_.throughput, sampler_.next2());
      if (!is_black(sample.emitted)) {
        History with = history_;
        with.mark_medium();
        radiance_.add(with.destination(radiance_), slot_, state_.throughput * sample.emitted,
                      scene_.source_of_medium(state_.medium.index));
      }
      state_.throughput *= sample.weight;
      if (sample.scatters) scatters = scatter(medium, segment, sample.distance);
      return !sample.scatters;
    });
    met_at_ = state_.ray.origin + state_.ray.direction * hit.distance;
    return arrives ? End::surface : scatters ? End::scattering : End::nothing;
  }

  /// Scatters the path in a medium; false if it ends.
  bool scatter(const Medium& medium, const LitSegment& segment, float distance) {
    if (is_black(state_.throughput) || bounce_ >= settings_.max_bounces) return false;
    MediumVertex vertex{state_.ray.origin + state_.ray.direction * distance,
                        -state_.ray.direction,
                        medium.g,
                        {state_.medium.index, true},
                        state_.ray.time};
    history_.mark_medium();
    segment_ = segment;
    on_segment_ = distance;
    const Vec2 pair = sampler_.next2();
    const LightSample light = sample_light(scene_, vertex.position, pair.x, {sampler_.next1(), pair.y});
    if (light.pdf > 0) {
      const float others = (light.delta ? 0.0f : vertex.phase(light.direction)) +
                           light.pdf * segment.ratio(scene_, light.source, distance, light.position);
      add_scattered(scattered_light(light, vertex, balance_heuristic(1, light.pdf, 1, others)), state_.throughput);
    }
    const Vec3 direction = vertex.sample(sampler_.next2());
    state_.pdf = vertex.phase(direction);
    state_.scattered_at = vertex.position;
    state_.medium = vertex.medium;
    state_.ray = {vertex.position, 0, direction, std::numeric_limits<float>::infinity(), state_.ray.time};
    return survives();
  }

  /// Light of lamps that the medium scatters along a piece of the path, sampled by their place.
  void add_segment_light(const LitSegment& segment) {
    if (!segment.samples() || bounce_ >= settings_.max_bounces) return;
    const Vec2 u = sampler_.next2();
    const SegmentLight light = segment.sample(scene_, u, sampler_.next2());
    if (!(light.sample.pdf > 0)) return;
    const float others = light.by_place + (light.sample.delta ? 0.0f : light.vertex.phase(light.sample.direction));
    const float weight = balance_heuristic(1, light.sample.pdf, 1, others * light.by_transmittance);
    const History before = history_;
    history_.mark_medium();
    add_scattered(scattered_light(light.sample, light.vertex, weight), state_.throughput * light.weight);
    history_ = before;
  }

  void add_scattered(const UnoccludedLight& light, RGB throughput) {
    if (is_black(light.radiance)) return;
    ++shadow_rays;
    radiance_.add(history_.destination(radiance_), slot_, throughput * light.radiance * passed_share(tracer_, light),
                  light.source);
  }

  void see(const Hit& hit) {
    first_hit_.depth[slot_] = length_to(hit);
    if (crosses_media_) first_hit_.depth[slot_] += length(state_.ray.origin - start_at_);
    if (first_hit_.triangle.empty()) return;
    first_hit_.triangle[slot_] = hit.triangle;
    first_hit_.barycentric[slot_] = hit.barycentric;
  }

  /// Next-event estimation, separately for each kind of lobe, whose light belongs to different layers.
  void add_sampled_light(const Vertex& vertex) {
    const Vec2 pair = sampler_.next2();
    const float u = sampler_.next1();
    if (!takes_light_samples(vertex.bsdf)) return;
    const LightSample sample = sample_light(scene_, vertex, pair, u);
    for (const Lobes which : {kBroad, kSpecular}) {
      if (!vertex.has(which)) continue;
      const UnoccludedLight light = reflected_light(sample, vertex, which, kAllLobes);
      if (is_black(light.radiance)) continue;
      ++shadow_rays;
      const RGB passed = passed_share(tracer_, light);
      if (is_black(passed)) continue;
      History with = history_;
      with.mark(which == kSpecular ? kSpecular : kDiffuseReflection, false);
      radiance_.add(with.destination(radiance_), slot_, state_.throughput * light.radiance * passed, light.source);
    }
  }

  void add_lookup(const Vertex& vertex) {
    // Light that photons bring has met one surface at least before the one that is looked up.
    if (!lookups_ || !vertex.has(kBroad) || bounce_ + 1 >= settings_.max_bounces) return;
    add_query(history_.gathered ? lookups_->indirect : lookups_->caustic, vertex, state_.throughput, slot_);
  }

  /// Continues in a direction sampled from the BSDF; false if the path ends.
  bool go_on(const Vertex& vertex) {
    const float u_lobe = sampler_.next1();
    const ScatteredRay s = vertex.surface().sample(vertex.wo, u_lobe, sampler_.next2(), kAllLobes);
    if (!leave(state_, vertex, s, s.weight) || !survives()) return false;
    if (s.is_null) return true;  // shadow rays pass through panes, too
    history_.mark(s.lobe, s.delta);
    segment_ = {};
    return true;
  }
  bool survives() {
    const float weight = max_component(state_.throughput) / start_;
    return survive(state_, weight, kLeastOfPaths, bounce_ + 1, [&] { return sampler_.next1(); }) > 0;
  }

  const Tracer& tracer_;
  const Scene& scene_;
  const RenderSettings& settings_;
  Sampler sampler_;
  std::uint32_t slot_;
  SlotRadiance& radiance_;
  FirstHit& first_hit_;
  Lookups* lookups_;
  PathState state_;
  float start_ = 1;  // the throughput before the first bounce
  int bounce_ = 0;   // before, at surfaces and in media
  History history_;
  const bool crosses_media_;
  LitSegment segment_;    // where the path scattered last, if that was in a medium,
  float on_segment_ = 0;  // and the place on it, metres
  Vec3 met_at_{};         // the end of the ray
  Vec3 start_at_{};       // the camera
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
        statistics_(statistics) {
    if (view.camera) camera_medium_ = camera_medium(tracer, *view.camera);
    if (maps && view.points && !view.points->on_surfaces && !view.points->delta_lights_apart)
      images_ = maps->air().images.get();
  }

  /// Traces all samples of a task.
  void trace(const CameraTask& task, std::size_t first_slot) {
    // The query points of 4096 samples fit the memory of a thread's rays (kBytesPerThread).
    const std::size_t at_once = maps_ ? 4096 : task.slot_count();
    for (std::size_t first = 0; first < task.slot_count(); first += at_once) {
      trace(task, first_slot, first, std::min(first + at_once, task.slot_count()));
      if (maps_) look_up();
    }
  }

 private:
  void trace(const CameraTask& task, std::size_t first_slot, std::size_t first, std::size_t last) {
    found_.clear();
    const std::size_t chunks = (last - first + kSamplesPerChunk - 1) / kSamplesPerChunk;
    const auto make = [&](std::size_t chunk, Lookups& lookups) {
      const std::size_t begin = first + chunk * kSamplesPerChunk, end = std::min(begin + kSamplesPerChunk, last);
      lookups.clear();
      std::uint64_t shadow_rays = 0;
      for (std::size_t i = begin; i < end; ++i) shadow_rays += trace_sample(task, first_slot, i, lookups);
      statistics_.add(Counter::camera_rays, end - begin);
      statistics_.add(Counter::occlusion_rays, shadow_rays);
    };
    make_parts<Lookups>(chunks, make, [&](const Lookups& lookups) { found_.append(lookups); });
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
    Sampler sampler(settings_.sampler, settings_.sample_seed(),
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
    if (ray.is_blind()) {
      first_hit_.depth[slot] = std::numeric_limits<float>::infinity();
      return 0;
    }
    Path path = start(sampler);
    path.trace_from(ray, camera_medium_);
    return path.shadow_rays;
  }

  void look_up() {
    look_up(found_.caustic, radiance_.caustic);
    look_up(found_.indirect, radiance_.indirect);
    add_air_light(tracer_, maps_->air(), found_.air, radiance_, radiance_.caustic, statistics_);
    if (images_) add_image_light(tracer_, *images_, found_.air, radiance_, radiance_.caustic, statistics_);
  }

  void look_up(const QueryPoints& queries, std::vector<RGB>& target) {
    const PhotonMaps::Engines& engines = maps_->caustic_engines();
    for (std::size_t i = 0; i < engines.size(); ++i) {
      found_light_.assign(queries.size(), RGB());
      engines[i]->estimate(queries, found_light_, statistics_);
      complete(queries, found_light_, target, statistics_);
      if (!radiance_.groups.empty() && !engines.grouped)
        complete(queries, found_light_, radiance_.groups[i], statistics_);
    }
    if (engines.grouped) engines.grouped->add(queries, radiance_.groups, statistics_);
  }

  const Tracer& tracer_;
  const View& view_;
  const RenderSettings& settings_;
  const PhotonMaps* maps_;
  SlotRadiance& radiance_;
  FirstHit& first_hit_;
  Statistics& statistics_;
  PathMedium camera_medium_;
  const SunImages* images_ = nullptr;  // for points in air; null: none
  Lookups found_;
  LargeVector<RGB> found_light_;
};

}  // namespace

void trace_paths(const Tracer& tracer, const View& view, CameraTasks tasks, const RenderSettings& settings,
                 const PhotonMaps* maps, SlotRadiance& radiance, FirstHit& first_hit, Statistics& statistics) {
  radiance.resize(tasks.slot_count(), !tracer.scene().media().empty());
  first_hit.resize(tasks.slot_count(), settings.place_layers().of_triangles());
  PathPass pass(tracer, view, settings, maps, radiance, first_hit, statistics);
  std::size_t first_slot = 0;
  for (const CameraTask& task : tasks) {
    pass.trace(task, first_slot);
    first_slot += task.slot_count();
  }
}

}  // namespace glowworm
