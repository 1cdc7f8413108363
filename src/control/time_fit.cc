#include "control/time_fit.h"

#include <algorithm>
#include <cmath>

#include "control/job.h"
#include "core/error.h"
#include "core/parallel.h"
#include "gather/direct_light.h"
#include "maps/photon_guiding.h"
#include "settings/options.h"

namespace glowworm {

namespace {

/// Most of the time left that photons, and then a first image, may take.
constexpr double kPhotonShare = 0.4, kImageShare = 0.8;
/// Tasks that measure are squares of at most this side, in pixels, in so many rows and columns.
constexpr int kTaskSide = 32, kTaskRows = 2;

}  // namespace

AutomaticNumbers automatic_numbers(const RenderSettings& asked) {
  return {asked.photons == 0, asked.gather == 0, asked.light_samples == 0};
}

RenderSettings with_numbers_of(RenderSettings asked, const RenderKey& kept) {
  const bool by_time = asked.time_limit_s > 0;
  const AutomaticNumbers automatic = automatic_numbers(asked);
  const auto find = [&](const char* name) {
    return std::find_if(kept.begin(), kept.end(), [&](const KeyPart& part) { return part.name == name; });
  };
  const auto target = find(kPhotonTarget);
  const bool has_target = target != kept.end() && target->value != kNoPhotonTarget;
  for (const Option& option : render_options()) {
    const std::string name = option.name;
    const bool taken = name == kPhotonTarget ? automatic.photons && has_target
                       : name == "--photons" ? automatic.photons
                       : name == "--gather"  ? automatic.gather && by_time
                                             : automatic.light_samples && by_time && name == "light samples";
    const auto part = find(option.name);
    if (taken && part != kept.end()) option.parse(asked, part->value);
  }
  return asked;
}

bool may_need_fitting(const RenderSettings& s, const AutomaticNumbers& automatic, double room_s) {
  if (s.time_limit_s <= 0 || !(automatic.photons || automatic.gather)) return false;
  const bool gathers = s.integrator == Integrator::gather;
  const double rays = gathers ? static_cast<double>(s.bounds.pixel_count()) * s.gather : 0;
  return static_cast<double>(s.photons) * kMostSlowdown * kUsualCost.photon_s > kPhotonShare * room_s ||
         rays * kMostSlowdown * kUsualCost.ray_s > (1 - kPhotonShare) * room_s;
}

RenderSettings with_fewer_photons(RenderSettings s, double share) {
  s.photons = std::min(s.photons, std::max(two_digits(static_cast<double>(s.photons) * share), kLeastPhotons));
  return s;
}

RenderSettings fitted_settings(const RenderSettings& settings, const AutomaticNumbers& automatic, const Cost& cost,
                               double room_s) {
  RenderSettings s = settings;
  const double photons_s = cost.photon_s * static_cast<double>(s.photons);
  double share = std::min(1.0, std::max(kPhotonShare * room_s, 0.0) / photons_s);
  if (!automatic.photons) share = 1;
  if (share < 1) s = with_fewer_photons(s, share);
  if (!automatic.gather || cost.ray_s <= 0) return s;
  // The pilot pass of the gather guide traces half of the rays of a first image.
  const double image_s = cost.sample_s(s.gather) * static_cast<double>(s.bounds.pixel_count()) * 1.5;
  const double image_room_s = std::max(kImageShare * (room_s - share * photons_s), 0.0);
  if (image_s <= image_room_s) return s;
  s.gather = static_cast<std::uint32_t>(std::max(s.gather * image_room_s / image_s, 1.0));
  if (automatic.light_samples) s.light_samples = default_light_samples(s.gather);
  return s;
}

std::vector<CameraTask> spread_tasks(const PixelBounds& bounds) {
  const double largest = kPilotShare * static_cast<double>(bounds.pixel_count()) / (kTaskRows * kTaskRows);
  const int side = std::clamp(static_cast<int>(std::sqrt(largest)), 1, kTaskSide);
  std::vector<CameraTask> tasks;
  for (int row = 0; row < kTaskRows; ++row) {
    for (int column = 0; column < kTaskRows; ++column) {
      const auto begin = [&](int first, int length, int i) { return first + length * (2 * i + 1) / (2 * kTaskRows); };
      const int x = std::max(begin(bounds.x0, bounds.width(), column) - side / 2, bounds.x0);
      const int y = std::max(begin(bounds.y0, bounds.height(), row) - side / 2, bounds.y0);
      tasks.push_back({x, y, std::min(x + side, bounds.x1), std::min(y + side, bounds.y1), 0, 1});
    }
  }
  return tasks;
}

double Job::measure_slot() {
  const Schedule schedule = make_schedule(settings_, budget_.available());
  PassSettings pass = pass_;
  pass.queries_at_once = schedule.queries_at_once;
  pass.by_disk = schedule.by_disk;
  Statistics not_the_renders;
  const double start = seconds();
  std::uint64_t slots = 0;
  for (const CameraTask& task : spread_tasks(settings_.bounds)) {
    render_pass(*tracer_, made_->maps, view(), task, pass, budget_, memory_, not_the_renders);
    slots += task.slot_count();
  }
  return (seconds() - start) / static_cast<double>(slots);
}

void Job::fit_to_time() {
  if (!time_.is_set()) return;
  rehearse();
  if (!may_need_fitting(settings_, automatic_, time_.left_s() / job_end_.least_passes)) return;
  const CancellationScope scope(interrupt_);
  const double start = seconds();
  is_mapping_ = true;
  Statistics not_the_renders;
  Cost cost;
  const RenderSettings few = with_fewer_photons(settings_, kPilotShare);
  // Timed apart, because guiding takes nearly as long for few photons as for many.
  guide_emission(few, not_the_renders);
  const double guided = seconds();
  make_maps(few, settings_.sample_range().first, not_the_renders);
  cost.photon_s = (seconds() - guided) / static_cast<double>(few.photons);
  if (pass_.kind == PassKind::gather) cost.ray_s = measure_slot() / settings_.gather;
  made_->maps.forget();
  made_->fixed_radius = 0;
  const double again_s = guiding_paths(few) == guiding_paths(settings_) ? 0 : guided - start;
  // Fewer photons and gather rays than fit into a tenth of the time would spoil the picture.
  const RenderSettings fitted = fitted_settings(
      settings_, automatic_, cost, std::max((time_.left_s() - again_s) / job_end_.least_passes, 0.1 * time_.whole_s()));
  if (guiding_paths(few) != guiding_paths(fitted)) {
    made_->guide.reset();
    made_->importance.reset();
  }
  statistics_.add_time(Phase::trace_photons, seconds() - start);
  is_mapping_ = false;
  if (fitted.photons == settings_.photons && fitted.gather == settings_.gather) return;
  const std::scoped_lock lock(key_mutex_, settings_mutex_);
  settings_.photons = fitted.photons;
  settings_.gather = fitted.gather;
  settings_.light_samples = fitted.light_samples;
  pass_ = pass_settings();
  key_.reset();
  fitted_ = true;
}

}  // namespace glowworm
