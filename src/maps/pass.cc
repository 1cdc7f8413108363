#include "maps/pass.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/parallel.h"
#include "gather/direct_light.h"
#include "gather/final_gather.h"
#include "maps/image_light.h"
#include "maps/memory.h"
#include "photon/material_lobes.h"
#include "transport/vertex.h"

namespace glowworm {

namespace {

/// Bytes of a segment in a medium: itself, twice while they are joined, its radiance, and what a map takes for it.
std::uint64_t bytes_per_segment() {
  return 2 * bytes_each<VolumeSegments>() + sizeof(RGB) + VolumeMap::segment_bytes(1);
}

class PassRenderer {
 public:
  PassRenderer(const Tracer& tracer, const PhotonMaps& maps, const View& view, const PassSettings& settings,
               MemoryBudget& budget, PassMemory& memory, Statistics& statistics)
      : tracer_(tracer),
        maps_(maps),
        view_(view),
        settings_(settings),
        budget_(budget),
        memory_(memory),
        statistics_(statistics) {}

  PassResult render(CameraTasks tasks) {
    check_cancelled();
    if (finds_bias()) bias_.assign(tasks.slot_count(), RGB());
    find_light(tasks);
    for (const RGB& bias : bias_) out_.first_hit.of(SlotValue::bias).push_back(luminance(bias));
    return std::move(out_);
  }

 private:
  void find_light(CameraTasks tasks) {
    if (settings_.light_groups) name_groups(*settings_.light_groups, out_.radiance);
    GatherPoints& points = memory_.points;
    if (view_.points) {
      point_pass(tracer_, *view_.points, tasks, out_.radiance, out_.first_hit, points, statistics_);
      if (settings_.kind == PassKind::photons && is_apart())
        add_air_light(tracer_, maps_.air(), air_points(points), out_.radiance, out_.radiance.indirect, statistics_);
      else if (settings_.kind == PassKind::photons)
        look_up_global(gather_points_as_queries(points));
      else
        gather_light(points);
      return;
    }
    CameraPassSettings camera_settings;
    camera_settings.width = settings_.width;
    camera_settings.height = settings_.height;
    camera_settings.seed = settings_.seed;
    camera_settings.places = settings_.places;
    camera_settings.surface_samples = settings_.surface_samples;
    camera_settings.edges = settings_.edges;
    camera_settings.suns = finds_suns();
    camera_settings.glints_apart = !takes_delta_lights();
    camera_settings.photons_alone = settings_.query_points_alone;
    if (in_media()) camera_settings.segments = &memory_.segments;
    camera_pass(tracer_, *view_.camera, tasks, camera_settings, out_.radiance, out_.first_hit, points, statistics_);
    if (settings_.kind == PassKind::gather || settings_.kind == PassKind::photons) {
      look_up_media(memory_.segments, out_.radiance.medium);
      if (settings_.kind == PassKind::gather)
        gather_light(points);
      else
        look_up_global(gather_points_as_queries(points));
      if (settings_.values.has(SlotValue::radius)) find_radii(memory_.queries = gather_points_as_queries(points));
    }
    if (settings_.kind == PassKind::count_seen || settings_.kind == PassKind::count_gathered) count_photons(points);
  }

  void look_up_global(const QueryPoints& queries) {
    const auto correct = [&](bool is_narrow) {
      const PhaseTimer timer(statistics_, Phase::density);
      maps_.correct(tracer_, queries, memory_.found, is_narrow);
    };
    if (settings_.query_points_alone)
      keep(queries, correct, out_.global_points);
    else
      look_up(queries, maps_.engines(), maps_.narrow(), correct, out_.radiance.indirect);
  }

  void look_up_caustic(const QueryPoints& queries, std::vector<RGB>& target) {
    const auto correct = [](bool) {};
    if (settings_.query_points_alone)
      keep(queries, correct, out_.caustic_points);
    else
      look_up(queries, maps_.caustic_engines(), maps_.narrow_caustic(), correct, target);
  }

  /// @param correct as of look_up()
  template <class Correct>
  void keep(const QueryPoints& queries, const Correct& correct, QueryPoints& kept) {
    const std::size_t first = kept.size();
    kept.append(queries);
    memory_.found.assign(queries.size(), RGB(1.0f));
    correct(false);
    for (std::size_t i = 0; i < queries.size(); ++i) kept.weight[first + i] *= memory_.found[i];
  }

  bool in_media() const { return !tracer_.scene().media().empty(); }

  /// Adds the light that photons in media bring to segments.
  void look_up_media(const VolumeSegments& segments, std::vector<RGB>& target) {
    if (segments.size() == 0) return;
    const VolumeMaps& maps = settings_.query_points_alone ? maps_.signed_media() : maps_.in_media();
    add_light_of_media(maps, segments, memory_.found, target, out_.radiance.groups, statistics_);
    memory_.segments.clear();
  }

  /// Factors on the estimates of engines.
  struct Factors {
    float light, bias;
  };

  /// Adds the radiance of query points, and its bias where that is wanted. The bias of an estimate E is nearly
  /// proportional to its kernels' area A (Silverman, Density Estimation for Statistics and Data Analysis, 1986, chapter
  /// 4): it is 2 (E(A) - E(A/2)). A pass that extrapolates adds 2 E(A/2) - E(A), the light of kernels without area
  /// (Schucany and Sommers, "Improvement of Kernel Type Density Estimators", 1977).
  /// @param correct is called after each lookup: (whether it was one of `narrow`)
  template <class Correct>
  void look_up(const QueryPoints& queries, const PhotonMaps::Engines& engines, const PhotonMaps::Engines& narrow,
               const Correct& correct, std::vector<RGB>& target) {
    count_held(queries);
    const bool extrapolates = settings_.extrapolates && !narrow.empty();
    const auto add = [&](const PhotonMaps::Engines& from, Factors factors, Statistics& statistics) {
      add_estimates(
          queries, from, factors, [&] { correct(&from == &narrow); }, target, statistics);
    };
    add(engines, {extrapolates ? -1.0f : 1.0f, 2}, statistics_);
    Statistics not_the_renders;
    if (extrapolates)
      add(narrow, {2, -2}, statistics_);
    else if (finds_bias())
      add(narrow, {0, -2}, not_the_renders);
  }

  /// Adds the estimates of engines. @param correct is called after each lookup
  template <class Correct>
  void add_estimates(const QueryPoints& queries, const PhotonMaps::Engines& engines, Factors factors,
                     const Correct& correct, std::vector<RGB>& target, Statistics& statistics) {
    const bool in_groups = settings_.light_groups && factors.light != 0;
    for (std::size_t i = 0; i < engines.size(); ++i) {
      memory_.found.assign(queries.size(), RGB());
      engines[i]->estimate(queries, memory_.found, statistics);
      correct();
      if (factors.light != 0) complete(queries, memory_.found, target, statistics, factors.light);
      if (in_groups && !engines.grouped)
        complete(queries, memory_.found, out_.radiance.groups[i], statistics, factors.light);
      if (finds_bias()) complete(queries, memory_.found, bias_, statistics, factors.bias);
    }
    if (in_groups && engines.grouped) engines.grouped->add(queries, out_.radiance.groups, statistics, factors.light);
  }

  void count_held(const QueryPoints& queries) {
    memory_.most_query_bytes =
        std::max<std::uint64_t>(memory_.most_query_bytes, queries.size() * (bytes_each<QueryPoints>() + sizeof(RGB)));
  }

  void gather_light(const GatherPoints& points) {
    if (!(tracer_.scene().light_power().total() > 0)) return;
    const bool rays_alone = settings_.kind == PassKind::gather_rays;
    if (settings_.direct && !rays_alone)
      add_direct_light(tracer_, points,
                       {settings_.seed, settings_.light_samples, settings_.gather, settings_.guide,
                        takes_delta_lights(), !finds_suns()},
                       out_.radiance, statistics_);
    if (settings_.caustic && !rays_alone) {
      if (is_apart())
        add_light_in_air(points);
      else
        look_up_caustic(gather_points_as_queries(points), out_.radiance.caustic);
    }
    // Gather rays that hit lights are part of direct light.
    if (settings_.direct || settings_.indirect) gather(points);
  }

  void add_light_in_air(const GatherPoints& points) {
    const std::vector<AirPoint> places = air_points(points);
    add_air_light(tracer_, maps_.air(), places, out_.radiance, out_.radiance.caustic, statistics_);
    if (takes_delta_lights() && maps_.air().images)
      add_image_light(tracer_, *maps_.air().images, places, out_.radiance, out_.radiance.caustic, statistics_);
  }

  /// Whether surface samples take directional lights in place of light samples.
  bool finds_suns() const {
    return settings_.surface_samples && settings_.direct && view_.camera && settings_.kind == PassKind::gather &&
           settings_.light_samples > 0 && takes_delta_lights() &&
           tracer_.scene().light_selector().directional_count() > 0;
  }

  /// Whether light samples take lights without size. Not for daylight coefficients, in whose scenes suns are lights of
  /// their own and the sky is one in parts (measure/year.h): rays towards the actual suns find their direct light.
  bool takes_delta_lights() const {
    if (view_.points) return !view_.points->delta_lights_apart;
    return !(tracer_.scene().environment() && tracer_.scene().environment()->parts);
  }

  FinalGatherSettings gather_settings() const {
    FinalGatherSettings out;
    out.rays = settings_.gather;
    out.seed = settings_.seed;
    out.light_samples = settings_.direct ? settings_.light_samples : 0;
    out.radii = settings_.secondary_gather ? &maps_.radii() : nullptr;
    out.guide = settings_.guide;
    out.bright = settings_.patches ? &maps_.bright_patches() : nullptr;
    out.patch_samples = default_patch_samples(settings_.gather);
    out.adds_caustics = settings_.caustic && is_apart();
    // Points are measured, and their error is stated.
    out.gathers_on = view_.points != nullptr;
    out.photons_alone = settings_.query_points_alone;
    return out;
  }

  /// Whether the gather points lie apart from surfaces, where no photons are. Gather rays find lights through sharp
  /// bounces, and photons that pass bring the light of those without size.
  bool is_apart() const { return view_.points && !view_.points->on_surfaces; }

  /// Bytes of a query point, whose surface may not be Lambertian.
  std::uint64_t bytes_per_query() const {
    return kBytesPerQuery + (may_have_lobes(tracer_.scene(), kGlossy) ? sizeof(QueryBsdf) : 0);
  }

  /// Final gathering in portions: each portion is traced, looked up and completed before the next.
  void gather(const GatherPoints& points) {
    const FinalGatherSettings gather = gather_settings();
    const std::size_t rays_each = gather.rays + (gather.looks_at_patches() ? gather.patch_samples : 0);
    const Reservation rays(budget_, "rays", kBytesPerThread * static_cast<std::uint64_t>(thread_count()));
    const bool caustics = settings_.indirect && !maps_.caustic_engines().empty();
    // The secondary gather looks up both maps.
    const std::uint64_t bytes_each = bytes_per_query() * (caustics ? 2 : 1) + (in_media() ? bytes_per_segment() : 0);
    const auto queries_at_once =
        static_cast<std::size_t>(std::min<std::uint64_t>(settings_.queries_at_once, budget_.available() / bytes_each));
    const std::size_t step = std::max<std::size_t>(1, queries_at_once / rays_each);
    const auto trace = [&](std::size_t first) {
      check_cancelled();
      final_gather(
          tracer_, points, first, std::min(first + step, points.size()), gather, out_.radiance,
          {memory_.queries, caustics ? &memory_.secondary_queries : nullptr, in_media() ? &memory_.segments : nullptr},
          statistics_);
      look_up_media(memory_.segments, out_.radiance.indirect);
      if (caustics) look_up_caustic(memory_.secondary_queries, out_.radiance.indirect);
    };
    const Reservation reservation(budget_, "query points", std::min(step, points.size()) * rays_each * bytes_each);
    // Each light group has an engine of its own, but a store is looked up once.
    if (!settings_.by_disk || finds_bias() || settings_.extrapolates || settings_.light_groups) {
      for (std::size_t first = 0; first < points.size(); first += step) {
        trace(first);
        if (settings_.kind == PassKind::count_gathered)
          count(memory_.queries, statistics_);
        else if (settings_.indirect)
          look_up_global(memory_.queries);
      }
      return;
    }
    // A ray that ends on a translucent sheet gives two query points.
    QueryStore store(maps_.bounds(), 2 * points.size() * rays_each);
    for (std::size_t first = 0; first < points.size(); first += step) {
      trace(first);
      const PhaseTimer timer(statistics_, Phase::reorder);
      store.append(memory_.queries);
    }
    memory_.queries = QueryPoints();
    const auto look_up_run = [&](const QueryPoints& run, std::span<RGB> found) {
      count_held(run);
      maps_.engines().front()->estimate(run, found, statistics_);
    };
    if (settings_.indirect && !maps_.engines().empty())
      store.complete(queries_at_once, look_up_run, out_.radiance.indirect);
    memory_.disk.read += store.traffic().read;
    memory_.disk.written += store.traffic().written;
  }

  void count_photons(const GatherPoints& points) {
    out_.diagnosis.assign(out_.first_hit.depth.size(), RGB());
    if (maps_.empty() || !maps_.diagnosis()) return;
    if (settings_.kind == PassKind::count_gathered)
      gather(points);
    else
      count(memory_.queries = gather_points_as_queries(points), statistics_);
  }

  bool finds_bias() const { return settings_.values.has(SlotValue::bias); }

  /// Fills SlotValue::radius. The counters of the render leave these lookups out. Changes `queries`.
  void find_radii(QueryPoints& queries) {
    const std::size_t slots = out_.first_hit.depth.size();
    std::vector<float>& radius = out_.first_hit.of(SlotValue::radius);
    radius.assign(slots, std::numeric_limits<float>::infinity());
    if (maps_.empty()) return;
    out_.diagnosis.assign(slots, RGB());
    Statistics not_the_renders;
    count(queries, not_the_renders);
    for (std::size_t i = 0; i < slots; ++i)
      if (const float mean = photon_diagnosis(out_.diagnosis[i]).mean_radius; mean > 0) radius[i] = mean;
    out_.diagnosis = {};
  }

  void count(QueryPoints& queries, Statistics& statistics) {
    // With a Lambertian reflectance of pi the result is the plain sum.
    std::fill(queries.reflectance.begin(), queries.reflectance.end(), RGB(kPi));
    std::fill(queries.bsdf.begin(), queries.bsdf.end(), kLambertianQuery);
    std::fill(queries.weight.begin(), queries.weight.end(), RGB(1.0f));
    queries.bsdfs.clear();
    memory_.found.assign(queries.size(), RGB());
    count_held(queries);
    maps_.diagnosis()->estimate(queries, memory_.found, statistics);
    complete(queries, memory_.found, out_.diagnosis, statistics);
  }

  const Tracer& tracer_;
  const PhotonMaps& maps_;
  const View& view_;
  const PassSettings& settings_;
  MemoryBudget& budget_;
  PassMemory& memory_;
  Statistics& statistics_;
  PassResult out_;
  std::vector<RGB> bias_;  ///< by slot
};

}  // namespace

void name_groups(const LightGroups& groups, SlotRadiance& radiance) {
  radiance.groups.resize(groups.names.size());
  radiance.group_of_source = groups.of_source;
}

void PassMemory::clear() {
  points = GatherPoints();
  queries = secondary_queries = QueryPoints();
  segments = VolumeSegments();
  found = LargeVector<RGB>();
  reservation.reset();
}

void PassMemory::keep(MemoryBudget& budget) {
  const std::uint64_t bytes =
      points.slot.capacity() * bytes_each<GatherPoints>() + queries.position.capacity() * bytes_each<QueryPoints>() +
      queries.bsdfs.capacity() * sizeof(QueryBsdf) + secondary_queries.position.capacity() * bytes_each<QueryPoints>() +
      secondary_queries.bsdfs.capacity() * sizeof(QueryBsdf) + found.capacity() * sizeof(RGB) +
      segments.origin.capacity() * bytes_each<VolumeSegments>();
  reservation.reset();
  if (bytes > budget.available() / 2)
    clear();
  else
    reservation = std::make_unique<Reservation>(budget, "query points", bytes);
}

PassResult render_pass(const Tracer& tracer, const PhotonMaps& maps, const View& view, CameraTasks tasks,
                       const PassSettings& settings, MemoryBudget& budget, PassMemory& memory, Statistics& statistics) {
  memory.reservation.reset();
  const std::size_t groups = settings.light_groups ? settings.light_groups->names.size() : 0;
  const Reservation reservation(budget, "camera samples",
                                tasks.slot_count() * bytes_per_slot(groups, settings.values.count(), settings.places,
                                                                    settings.surface_samples && view.camera));
  return PassRenderer(tracer, maps, view, settings, budget, memory, statistics).render(tasks);
}

}  // namespace glowworm
