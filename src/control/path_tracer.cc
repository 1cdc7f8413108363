#include "control/path_tracer.h"

#include <algorithm>
#include <limits>

#include "control/path_policy.h"
#include "core/make_parts.h"
#include "core/parallel.h"
#include "core/random.h"
#include "gather/final_gather.h"
#include "maps/image_light.h"

namespace glowworm {

namespace {

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
    const std::size_t grain = even_grain(last - first);
    const auto make = [&](std::size_t chunk, PathLookups& lookups) {
      const std::size_t begin = first + chunk * grain, end = std::min(begin + grain, last);
      lookups.clear();
      LightAdder lights(tracer_, radiance_);
      for (std::size_t i = begin; i < end; ++i) trace_sample(task, first_slot, i, lights, lookups);
      statistics_.add(Counter::camera_rays, end - begin);
      statistics_.add(Counter::occlusion_rays, lights.shadow_rays);
    };
    make_parts<PathLookups>((last - first + grain - 1) / grain, make,
                            [&](const PathLookups& lookups) { found_.append(lookups); });
  }

  void trace_sample(const CameraTask& task, std::size_t first_slot, std::size_t in_task, LightAdder& lights,
                    PathLookups& lookups) {
    const auto in_tile = static_cast<int>(in_task % task.pixel_count());
    const std::uint32_t sample = task.first_sample + static_cast<std::uint32_t>(in_task / task.pixel_count());
    const int width = task.x1 - task.x0, x = task.x0 + in_tile % width, y = task.y0 + in_tile / width;
    if (!task.has(x, y)) return;
    const auto slot = static_cast<std::uint32_t>(first_slot + in_task);
    const auto pixel =
        static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(settings_.width) + static_cast<std::uint32_t>(x);
    const PointGrid* const grid = view_.points;
    Sampler sampler(settings_.sampler, settings_.sample_seed(),
                    hash_combine(grid ? grid->sequence(pixel, sample) : pixel, kPathStream),
                    grid ? grid->place_in_sequence(sample) : sample);
    const auto path = [&] {
      return PathPolicy(tracer_, settings_, sampler, slot, radiance_, first_hit_, lights, maps_ ? &lookups : nullptr);
    };
    first_hit_.depth[slot] = std::numeric_limits<float>::infinity();
    if (grid) {
      if (grid->has(pixel)) path().trace_from(*grid, pixel, sample);
      return;
    }
    const Vec2 u = sampler.next2();
    const CameraRay ray = generate_ray(*view_.camera, {static_cast<float>(x) + u.x, static_cast<float>(y) + u.y},
                                       settings_.width, settings_.height, sampler.next2());
    if (!ray.is_blind()) path().trace_from(ray, camera_medium_);
  }

  void look_up() {
    look_up(found_.caustic, radiance_.caustic);
    look_up(found_.indirect, radiance_.indirect);
    add_light_of_media(maps_->in_media(), found_.in_media, found_light_, radiance_.medium, radiance_.groups,
                       statistics_);
    add_light_of_media(maps_->in_media(), found_.indirect_in_media, found_light_, radiance_.indirect, radiance_.groups,
                       statistics_);
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
  const LightImages* images_ = nullptr;  // for points in air; null: none
  PathLookups found_;
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
