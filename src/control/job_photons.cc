// The part of Job that makes the photon maps.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>

#include "control/job.h"
#include "core/log.h"
#include "maps/fixed_radius.h"
#include "maps/gather_guiding.h"
#include "maps/photon_noise.h"
#include "photon/material_lobes.h"

namespace glowworm {

PhotonMapSettings Job::map_settings(const RenderSettings& s, std::uint32_t pass) const {
  PhotonMapSettings wanted;
  wanted.photons = s.photons;
  wanted.thinned = s.thinned;
  wanted.nearest = s.nearest;
  wanted.engine = s.engine;
  wanted.reorder = s.reorder;
  wanted.kernel = s.kernel;
  wanted.fixed_radius = s.fixed_radius;
  wanted.radius = s.radius > 0 ? s.radius : made_->fixed_radius;
  wanted.caustic_radius = s.radius;
  wanted.seed = s.photon_seed();
  wanted.pass = s.progressive ? pass : 0;
  wanted.radius_scale = s.progressive ? progressive_radius_scale(pass) : 1.0f;
  wanted.max_bounces = photon_bounces(s.max_bounces);
  wanted.guide = made_->guide;
  wanted.importance = made_->importance;
  const bool gathers = s.integrator == Integrator::gather;
  wanted.on_all_surfaces = s.of_points && s.integrator == Integrator::photons;
  if (s.boundary_correction)
    wanted.correction =
        s.integrator == Integrator::photons ? BoundaryCorrection::estimates : BoundaryCorrection::photons;
  wanted.secondary_gather = gathers && s.secondary_gather;
  wanted.patches = gathers && s.gather_guiding;
  if (!s.progressive && !s.indirect_only && has_time_for_caustics(s))
    wanted.more_caustic_paths =
        affordable_caustic_paths(static_cast<double>(s.width) * s.height * std::max(s.gather, 1u));
  const bool by_paths = s.integrator == Integrator::path;
  if (by_paths) wanted.choice = PhotonChoice::unseen_by_paths;
  if (points_ && !points_->on_surfaces && (s.integrator == Integrator::photons || bends_delta_lights(*scene_))) {
    wanted.in_air = points_;
    wanted.air_choice = by_paths  ? PhotonChoice::unseen_by_paths
                        : gathers ? PhotonChoice::caustic_of_deltas
                                  : PhotonChoice::all;
    wanted.air_extrapolates = by_paths;
  }
  wanted.light_groups = light_groups_;
  wanted.diagnosed = s.place_layers().values.has(SlotValue::radius);
  wanted.narrow_caustic = s.place_layers().values.has(SlotValue::bias);
  wanted.narrow = wanted.narrow_caustic || s.extrapolates;
  wanted.sampled = measures_photon_noise_;
  wanted.kept = false;
  wanted.most_kept_bytes = most_kept_bytes_;
  wanted.shared = sharers(wanted.pass);
  return wanted;
}

void Job::guide_emission(const RenderSettings& s, Statistics& statistics) {
  if (!s.guiding || made_->guide || s.integrator == Integrator::path) return;
  const PhaseTimer timer(statistics, Phase::trace_photons);
  PhotonGuiding guiding = guide_photons(*tracer_, guide_view(), s, shared_.get());
  made_->guide = std::make_shared<const EmissionGuide>(std::move(guiding.guide));
  made_->importance = std::make_shared<const PhotonImportance>(std::move(guiding.importance));
}

SharedWork* Job::sharers(std::uint32_t pass) const {
  // Passes of a progressive render belong to one part each, but all need the first for their guide.
  return pass == 0 && !has_more_photons_ ? shared_.get() : nullptr;
}

void Job::make_maps(const RenderSettings& s, std::uint32_t sample, Statistics& statistics) {
  // Photons may use all memory that tasks leave.
  memory_.clear();
  guide_emission(s, statistics);
  const DiskMemory::Scope scope(disk_.get());
  if (s.fixed_radius && !(map_settings(s, 0).radius > 0)) {
    const PhaseTimer timer(statistics, Phase::build_photon_map);
    // All passes of a progressive render have the radius of the first.
    made_->fixed_radius =
        fixed_radius_for(*tracer_, made_->maps, map_settings(s, 0), guide_view(), s.bounds, guide_pass(), budget_);
  }
  made_->maps.update(*tracer_, map_settings(s, sample), statistics);
}

void Job::find_photon_noise(std::uint32_t sample) {
  do {
    make_maps(settings_, sample, statistics_);
    {
      const PhaseTimer timer(statistics_, Phase::photon_noise);
      photon_variance_ =
          measure_photon_variance(*tracer_, made_->maps, guide_view(), settings_.bounds, guide_pass(), budget_);
    }
    detail(fmt::format("{} photons add a relative error of {:.2g}", settings_.photons, std::sqrt(photon_variance_)));
  } while (take_more_photons());
  measures_photon_noise_ = false;
  if (!guide_cameras_.empty()) made_->photon_variance = photon_variance_;
}

bool Job::take_more_photons() {
  const RenderSettings more = with_photons_for_noise(settings_, photon_variance_);
  if (has_more_photons_ || more.photons == settings_.photons) return false;
  key();  // Renders that continue begin with the photons of before.
  const std::lock_guard lock(settings_mutex_);
  settings_.photons = more.photons;
  settings_.nearest = more.nearest;
  made_->fixed_radius = 0;
  return has_more_photons_ = true;
}

void Job::shoot_photons(std::uint32_t sample) {
  const CancellationScope scope(interrupt_);
  const double start = seconds();
  is_mapping_ = true;
  const bool gathers = settings_.integrator == Integrator::gather;
  if (gathers && settings_.gather_guiding && !made_->has_gather_guide) {
    // From the first map alone, whichever pass comes first here: all passes of all parts have the same guide.
    Statistics not_the_renders;
    const bool is_own = sample == 0 || !settings_.progressive;
    {
      const PhaseTimer timer(statistics_, Phase::trace_photons);
      make_maps(settings_, 0, is_own ? statistics_ : not_the_renders);
    }
    made_->gather_guide =
        learn_gather_guide(*tracer_, made_->maps, guide_view(), guide_pass(), budget_, statistics_, shared_.get());
    made_->has_gather_guide = true;
    made_->fixed_radius = 0;  // guided rays end elsewhere
  }
  if (measures_photon_noise_) find_photon_noise(sample);
  make_maps(settings_, sample, statistics_);
  if (!guide_cameras_.empty())
    made_->numbers = {settings_.photons, settings_.nearest, settings_.gather, settings_.light_samples};
  photon_seconds_ = seconds() - start;
  photon_map_bytes_ = made_->maps.bytes();
  is_mapping_ = false;
  if (shared_) detail(fmt::format("{}: {} pieces made, {} read", shared_->folder(), shared_->made(), shared_->read()));
  const std::lock_guard lock(film_mutex_);
  add(light_photons_, photons_by_light(*scene_, made_->maps.pass()));
}

}  // namespace glowworm
