#include "session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "control/scheduler.h"
#include "core/error.h"
#include "core/parallel.h"
#include "gather/direct_light.h"
#include "maps/gather_guiding.h"
#include "maps/memory.h"
#include "maps/photon_guiding.h"
#include "points/finite_light.h"
#include "session/preview_filter.h"

namespace glowworm {

namespace {

using Clock = std::chrono::steady_clock;

/// Passes of a view at rest that share photons before new ones are traced.
constexpr std::uint32_t kPassesOfMaps = 16;
constexpr int kMaxSide = 16384;
/// Approximate duration of a pass at rest, if frames adapt.
constexpr double kRestingSeconds = 0.25;
/// Of large arrays that were freed.
constexpr std::uint64_t kMaxSpareBytes = std::uint64_t{128} << 20;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Replaces a reading of the statistics by its difference from an earlier one.
class CostMeter {
 public:
  explicit CostMeter(const Statistics& statistics) : statistics_(statistics), start_(Clock::now()) {
    for (std::size_t i = 0; i < before_.phase_seconds.size(); ++i)
      before_.phase_seconds[i] = statistics.seconds(static_cast<Phase>(i));
    for (std::size_t i = 0; i < before_.counts.size(); ++i)
      before_.counts[i] = statistics.count(static_cast<Counter>(i));
  }

  void read(FrameCost& cost) const {
    for (std::size_t i = 0; i < before_.phase_seconds.size(); ++i)
      cost.phase_seconds[i] = statistics_.seconds(static_cast<Phase>(i)) - before_.phase_seconds[i];
    for (std::size_t i = 0; i < before_.counts.size(); ++i)
      cost.counts[i] = statistics_.count(static_cast<Counter>(i)) - before_.counts[i];
    cost.seconds = seconds_since(start_);
  }

 private:
  const Statistics& statistics_;
  Clock::time_point start_;
  FrameCost before_;
};

void check_state(const ViewState& s) {
  if (s.width < 1 || s.height < 1 || s.width > kMaxSide || s.height > kMaxSide)
    throw Error(fmt::format("a view of {}x{} pixels cannot be shown", s.width, s.height),
                fmt::format("Both sides must be from 1 to {}.", kMaxSide));
  if (s.gather == 0) throw Error("a view needs at least one gather ray");
  if (s.photons == 0) throw Error("a view needs at least one photon");
}

/// Keeps the working memory of a pass for the next, also if the pass was cancelled.
class PassMemoryKeeper {
 public:
  PassMemoryKeeper(PassMemory& memory, MemoryBudget& budget) : memory_(memory), budget_(budget) {}
  ~PassMemoryKeeper() { memory_.keep(budget_); }
  PassMemoryKeeper(const PassMemoryKeeper&) = delete;
  PassMemoryKeeper& operator=(const PassMemoryKeeper&) = delete;

 private:
  PassMemory& memory_;
  MemoryBudget& budget_;
};

/// The filter of a view at rest takes at most this share of the time of its passes; and from one filtered picture to
/// the next, its samples grow at least by this inverse share.
constexpr double kFilterShare = 0.5;
constexpr std::uint32_t kFilterGrowthInverse = 8;
/// Fewest samples whose spread tells the filter of renders their noise.
constexpr std::uint32_t kSamplesWithSpread = 2;

/// Whether the view shows light that a render would filter.
bool is_filtered(const ViewState& state) { return shows_light(state.mode) && filters(render_settings(state)); }

int scaled(int side, float scale) {
  return std::max(1, static_cast<int>(std::lround(static_cast<float>(side) * scale)));
}

}  // namespace

/// Differences from the last state.
struct Session::Change {
  bool moment = false;   ///< the scene's moment
  bool lights = false;   ///< the lights
  bool camera = false;   ///< the camera's position
  bool picture = false;  ///< content or size of the picture
  bool any() const { return moment || lights || camera || picture; }
};

Session::Session(std::shared_ptr<const Scene> scene, const SessionSettings& settings, SceneMoments moments)
    : settings_(settings),
      moments_(std::move(moments)),
      base_(std::move(scene)),
      rig_(base_),
      moment_rig_(rig_),
      scene_(base_),
      tracer_(std::make_unique<Tracer>(*base_)),
      budget_(settings.memory_bytes ? settings.memory_bytes : physical_memory_bytes() / 2) {
  // A frame with new photons makes the arrays of the frame before anew.
  const std::uint64_t spare = std::min(kMaxSpareBytes, budget_.available() / 8);
  spare_reservation_ = std::make_unique<Reservation>(budget_, "memory kept for the next frame", spare);
  spare_memory_ = std::make_unique<FreedMemoryKeeper>(spare);
}

Session::~Session() = default;

ViewState Session::initial_state() const {
  ViewState state;
  state.camera = base_->camera("");
  state.seconds = moments_.seconds;
  state.lights.resize(rig_.lights().size());
  if (base_->film().width > 0 && base_->film().height > 0) {
    state.width = base_->film().width;
    state.height = base_->film().height;
  }
  state.pivot_distance = pivot_distance(*tracer_, state.camera);
  return state;
}

Session::Change Session::compare(const ViewState& state) const {
  Change change;
  change.camera = !same_view(state.camera, state_.camera);
  change.moment = moments_.at && state.seconds != moments_.seconds;
  change.lights = state.lights != state_.lights;
  change.picture = !same_picture(state, state_);
  return change;
}

void Session::show_moment(const ViewState& state) {
  std::shared_ptr<const Scene> base = moments_.at(state.seconds);
  LightRig rig(base);
  tracer_ = std::make_unique<Tracer>(*base);  // the last that may throw
  moment_rig_ = std::move(rig);
  base_ = std::move(base);
  moments_.seconds = state.seconds;
  movable_ = false;
  state_.lights.assign(rig_.lights().size(), {});
  set_lights(state);
}

void Session::set_lights(const ViewState& state) {
  const std::vector<LightEdit> edits = moment_rig_.edits_of(rig_, state.lights);
  const bool same_geometry = moment_rig_.same_geometry(edits, moment_rig_.edits_of(rig_, state_.lights));
  const std::shared_ptr<const Scene> edited = moment_rig_.edited(edits);
  if (!same_geometry && !movable_) {
    // Only now, since rays are a little faster in a structure of one piece.
    tracer_ = std::make_unique<Tracer>(*base_, moment_rig_.movable_triangles());
    movable_ = true;
  }
  tracer_->follow(*edited);
  scene_ = edited;
  forget_photons();
  guide_.reset();
  map_guide_.reset();
  guided_ = false;
}

void Session::forget_photons() {
  maps_.forget();
  refined_.forget();
  has_maps_ = false;
}

void Session::forget_sums() {
  sums_.clear();
  filtered_ = {};
  next_filter_ = kSamplesWithSpread;
}

PhotonMapSettings Session::map_settings(const ViewState& state, std::uint64_t photons, bool moving) const {
  const bool gathers = state.mode == ViewMode::gather || state.mode == ViewMode::cost;
  PhotonMapSettings wanted;
  wanted.photons = photons;
  wanted.nearest = state.nearest;
  wanted.engine = engine_traits(state.engine).name;
  wanted.kernel = state.kernel;
  wanted.seed = settings_.seed;
  wanted.max_bounces = photon_bounces(RenderSettings().max_bounces);
  wanted.secondary_gather = gathers && state.secondary_gather && !(moving && settings_.adapt);
  wanted.diagnosed = needs_diagnosis(state.mode);
  if (moving || !shows_light(state.mode)) return wanted;
  // Lines for each point of the photons' own picture would take longer than the picture (maps/boundary.h).
  wanted.correction = BoundaryCorrection::photons;
  wanted.patches = gathers;
  wanted.more_caustic_paths = affordable_caustic_paths(static_cast<double>(state.width) * state.height * state.gather);
  return wanted;
}

void Session::update_maps(const ViewState& state, std::uint64_t photons, bool moving) {
  if (!needs_photons(state.mode)) return;
  const bool hasty = moving && settings_.adapt;
  if (!hasty && !guided_) guide_ = make_guide(state);
  guided_ = guided_ || !hasty;
  PhotonMapSettings wanted = map_settings(state, photons, moving);
  wanted.guide = hasty ? map_guide_ : guide_;
  const bool others = photons != map_photons_ || wanted.guide != map_guide_;
  // Photons first.
  if (others) pass_memory_.clear();
  const std::uint64_t bytes = photons * bytes_per_photon(!tracer_->scene().media().empty(), false);
  if (others && has_maps_ && settings_.adapt && budget_.available() >= bytes) {
    // The old photons stay until better ones exist: if this is interrupted, the next frame has a map.
    PhotonMaps better(budget_);
    better.update(*tracer_, wanted, statistics_);
    maps_ = std::move(better);
  } else {
    has_maps_ = has_maps_ && !others;
    maps_.update(*tracer_, wanted, statistics_);
  }
  map_photons_ = photons;
  map_guide_ = wanted.guide;
  has_maps_ = true;
}

std::shared_ptr<const EmissionGuide> Session::make_guide(const ViewState& state) {
  const PhaseTimer timer(statistics_, Phase::trace_photons);
  RenderSettings settings = render_settings(state);
  settings.seed = settings_.seed;
  auto guide = std::make_shared<const EmissionGuide>(guide_photons(*tracer_, state.camera, settings).guide);
  // Without gain this is the uniform guide, with which the photons do not change.
  return guide->gain() > 1 ? guide : nullptr;
}

const PhotonMaps& Session::resting_maps(const ViewState& state) {
  const std::uint32_t pass = sums_.count() / kPassesOfMaps;
  if (pass == 0 || !shows_light(state.mode)) {
    update_maps(state, state.photons, false);
    return maps_;
  }
  if (!refined_guide_) refined_guide_ = make_guide(state);
  PhotonMapSettings wanted = map_settings(state, state.photons, false);
  wanted.guide = *refined_guide_;
  wanted.pass = pass + 1;  // photons of passes 0 and 1 are in the first maps: 1 has their additional caustic photons
  wanted.radius_scale = progressive_radius_scale(pass);
  wanted.more_caustic_paths = 0;
  wanted.kept = false;
  if (sums_.count() % kPassesOfMaps == 0) pass_memory_.clear();  // photons come first
  refined_.update(*tracer_, wanted, statistics_);
  return refined_;
}

ViewFrame Session::next_frame(const ViewState& state, double seconds) {
  const Interrupt none;
  return next_frame(state, seconds, false, none);
}

ViewFrame Session::next_frame(const ViewState& state, double seconds, bool interacting, const Interrupt& interrupt) {
  check_state(state);
  const CostMeter meter(statistics_);
  const Change change = compare(state);
  const bool first = !started_;
  if (first || change.any()) {
    forget_sums();
    refined_.forget();
    refined_guide_.reset();
  }
  if (change.moment)
    show_moment(state);
  else if (first ? !state.lights.empty() : change.lights)
    set_lights(state);
  if (change.moment || change.lights || change.picture || first) history_.clear();
  state_ = state;
  started_ = true;
  const bool moving = change.any() || first || (settings_.adapt && interacting);
  // Frames that are mixed need independent noise; others must not flicker.
  if (moving) moving_sample_ = state.reuse && shows_light(state.mode) ? moving_sample_ + 1 : 0;
  // A timed frame is always finished: if every new state interrupted it, a moving view would show nothing.
  const Interrupt none;
  ViewFrame frame;
  {
    const CancellationScope scope(moving && settings_.adapt ? none : interrupt);
    check_cancelled();
    frame = render(state, moving);
  }
  const bool light = shows_light(state.mode), filtered = is_filtered(state);
  // The samples of one pass have no spread, which the filter of renders needs.
  const bool preview = filtered && frame.samples < kSamplesWithSpread;
  if (light && (state.reuse || preview)) frame.image.find_positions();
  // Noise of earlier frames has no place in a filtered picture.
  if (light && state.reuse && (preview || !filtered)) reuse(frame, seconds);
  if (preview) {
    const Clock::time_point start = Clock::now();
    filter_preview(frame.image);
    frame.cost.filter_seconds = seconds_since(start);
  }
  meter.read(frame.cost);
  learn(frame);
  return frame;
}

FrameEffort Session::plan(const ViewState& state, bool moving) const {
  FrameEffort effort{1, state.gather, state.photons};
  if (!settings_.adapt) return effort;
  const auto pixels = static_cast<std::uint64_t>(state.width) * static_cast<std::uint64_t>(state.height);
  const bool gathers = state.mode == ViewMode::gather || state.mode == ViewMode::cost;
  if (moving) {
    effort = pace_.plan(pixels, gathers ? state.gather : 0, state.photons, needs_photons(state.mode) && !has_maps_,
                        1 / settings_.frames_per_second);
    // Any map of this light is good enough until the view rests.
    if (has_maps_) effort.photons = map_photons_;
  } else if (gathers) {
    effort.gather = pace_.resting_gather(pixels, state.gather, kRestingSeconds);
  }
  effort.gather = std::max<std::uint32_t>(effort.gather, 1);
  return effort;
}

PassSettings Session::pass_settings(const ViewState& state, const FrameEffort& effort, bool moving) const {
  PassSettings pass;
  pass.kind = state.mode == ViewMode::gather    ? PassKind::gather
              : state.mode == ViewMode::photons ? PassKind::photons
              : !needs_photons(state.mode)      ? PassKind::surfaces
              : state.mode == ViewMode::cost    ? PassKind::count_gathered
                                                : PassKind::count_seen;
  pass.width = scaled(state.width, effort.scale);
  pass.height = scaled(state.height, effort.scale);
  pass.gather = effort.gather;
  pass.light_samples = default_light_samples(effort.gather);
  pass.seed = settings_.seed;
  const auto wants = [&](LightPart part) { return state.part == LightPart::all || state.part == part; };
  pass.direct = wants(LightPart::direct);
  pass.indirect = wants(LightPart::indirect);
  pass.caustic = wants(LightPart::caustic);
  pass.secondary_gather = state.secondary_gather && !(moving && settings_.adapt);
  pass.patches = pass.surface_samples = !moving && state.mode == ViewMode::gather;
  return pass;
}

ViewFrame Session::render(const ViewState& state, bool moving) {
  const FrameEffort effort = plan(state, moving);
  if (moving) update_maps(state, effort.photons, true);
  const PhotonMaps& maps = moving ? maps_ : resting_maps(state);
  const Clock::time_point start = Clock::now();
  // A view at rest starts again, with better maps.
  const std::uint32_t earlier = moving ? 0 : sums_.count();
  PassSettings pass = pass_settings(state, effort, moving);
  if (pass.patches) {
    if (earlier % kPassesOfMaps == 0)
      gather_guide_ = learn_gather_guide(*tracer_, maps, state.camera, pass, budget_, statistics_);
    pass.guide = &gather_guide_;
    if (earlier == 0) edges_.emplace(pass.width, pass.height);
    pass.edges = &*edges_;
  }
  const CameraTask task{0, 0, pass.width, pass.height, moving ? moving_sample_ : earlier, 1};
  const PassMemoryKeeper keeper(pass_memory_, budget_);
  PassResult result = render_pass(*tracer_, maps, state.camera, task, pass, budget_, pass_memory_, statistics_);
  drop_infinite_samples(result.radiance);
  ViewFrame frame;
  frame.moving = moving;
  frame.is_light = shows_light(state.mode);
  if (moving) {
    const float factor = frame.is_light ? base_->film().scale : 1.0f;
    frame.image = pass_image(result, state.camera, pass.width, pass.height, state.part, factor);
    frame.samples = 1;
    if (!frame.is_light) show_false_colors(state, result.diagnosis, frame);
  } else {
    sums_.add(std::move(result), pass.width, pass.height, state.part);
    show_resting(state, seconds_since(start), frame);
  }
  frame.effort = effort;
  frame.photons = needs_photons(state.mode) ? maps.global_count() : 0;
  if (needs_photons(state.mode)) frame.engine = maps.engines().front()->name();
  return frame;
}

void Session::reuse(ViewFrame& frame, double seconds) {
  const Clock::time_point start = Clock::now();
  const auto samples = static_cast<float>(frame.samples * frame.effort.gather);
  if (frame.moving) {
    history_.blend(frame.image, samples, seconds - history_seconds_);
    history_seconds_ = seconds;
  } else if (seconds - history_seconds_ < History::kLifetime) {
    history_.blend_resting(frame.image, samples, seconds - history_seconds_);
  } else {
    history_.clear();
  }
  frame.cost.reuse_seconds = seconds_since(start);
}

/// @param pass_seconds of the newest pass
void Session::show_resting(const ViewState& state, double pass_seconds, ViewFrame& frame) {
  const float factor = frame.is_light ? base_->film().scale : 1.0f;
  frame.samples = sums_.count();
  if (!is_filtered(state) || frame.samples < kSamplesWithSpread) {
    frame.image = sums_.image(state.camera, state.part, factor, false);
    if (!frame.is_light) show_false_colors(state, sums_.diagnosis(), frame);
    return;
  }
  if (frame.samples >= next_filter_) {
    const Clock::time_point start = Clock::now();
    filtered_ = sums_.image(state.camera, state.part, factor, true);
    filtered_samples_ = frame.samples;
    frame.cost.filter_seconds = seconds_since(start);
    // Frames that do not adapt must not depend on times.
    const double passes = frame.cost.filter_seconds / (kFilterShare * std::max(pass_seconds, 1e-9));
    const auto wait = static_cast<std::uint32_t>(std::clamp(passes, 1.0, 1e6));
    next_filter_ =
        frame.samples + (settings_.adapt ? std::max(wait, frame.samples / kFilterGrowthInverse) : std::uint32_t{1});
  }
  frame.image = filtered_;
  frame.samples = filtered_samples_;
}

void Session::show_false_colors(const ViewState& state, const std::vector<RGB>& diagnosis, ViewFrame& frame) const {
  ViewImage& image = frame.image;
  if (state.mode == ViewMode::albedo) {
    image.light = image.albedo;
    return;
  }
  if (state.mode == ViewMode::normal) {
    for (std::size_t i = 0; i < image.size(); ++i) {
      const Vec3 n = image.normal[i];
      const bool nothing = n == Vec3{0, 0, 0};
      image.light[i] = nothing ? RGB() : RGB((n.x + 1) / 2, (n.y + 1) / 2, (n.z + 1) / 2);
    }
    return;
  }
  std::vector<float> values(diagnosis.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const PhotonDiagnosis d = photon_diagnosis(diagnosis[i]);
    values[i] = state.mode == ViewMode::density  ? d.density
                : state.mode == ViewMode::radius ? d.mean_radius
                                                 : d.shader_operations;
  }
  frame.unit = state.mode == ViewMode::density  ? "photons per m^2"
               : state.mode == ViewMode::radius ? "m"
                                                : "shader operations per pixel";
  frame.scale = fitting_scale(values);
  image.light = false_colors(values, frame.scale);
}

void Session::learn(const ViewFrame& frame) {
  const FrameCost& cost = frame.cost;
  FrameWork work;
  // Views at rest sum and filter, which frames in motion do not.
  if (frame.moving) work.pixels = frame.image.size();
  work.photon_seconds = cost.phase(Phase::trace_photons) + cost.phase(Phase::build_photon_map);
  // Excludes correction, which frames in motion skip and which would make photons look expensive.
  if (frame.moving && cost.count(Counter::photons_stored) > 0) work.photons = cost.count(Counter::photons_stored);
  const double lookup = cost.phase(Phase::reorder) + cost.phase(Phase::density) + cost.phase(Phase::completion);
  work.gather_rays = cost.count(Counter::gather_rays);
  work.gather_seconds = cost.phase(Phase::gather_rays) + (work.gather_rays > 0 ? lookup : 0.0);
  work.camera_seconds = cost.seconds - work.photon_seconds - work.gather_seconds;
  pace_.learn(work);
}

}  // namespace glowworm
