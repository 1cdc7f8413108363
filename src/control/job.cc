#include "control/job.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <utility>
#include <vector>

#include "control/path_tracer.h"
#include "core/content_hash.h"
#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "film/output.h"
#include "maps/gather_guiding.h"
#include "maps/memory.h"
#include "maps/photon_noise.h"
#include "points/finite_light.h"

namespace glowworm {

namespace {

/// JobGuides::first_moment of a job that learns.
std::string hash_of_moment(const RenderKey& key) {
  ContentHash hash;
  hash.add(std::string_view(key_text(key_of_photons(key))));
  return fmt::format("{:016x}", hash.value());
}

/// Whether to test the noise after this pass. Few samples may not have found some light yet. The filter costs as much
/// as a share of a pass, so filtered pictures are tested each time their passes have grown by an eighth.
bool tests_noise_after(std::uint32_t passes, bool filtered) {
  if (!filtered) return passes >= 2;
  return passes >= kEvenSamples && passes % std::max(std::bit_floor(passes) / 8, 1u) == 0;
}

/// The settings with the size of the grid, and all of it unless they have bounds; as they are without points.
RenderSettings settings_for(RenderSettings settings, const PointGrid* points) {
  settings.of_points = points != nullptr;
  settings.extrapolates &=
      points && points->batches > 1 && settings.progressive && settings.integrator == Integrator::gather;
  if (!points) return settings;
  points->check();
  settings.width = points->width;
  settings.height = points->height;
  if (settings.bounds.empty()) settings.bounds = {0, 0, points->width, points->height};
  if (settings.place_layers().any())
    throw Error("points have no layers of the places that a camera sees",
                "Leave out the AOVs of what lies at a pixel, such as position, radius and ids.");
  return settings;
}

/// The settings with the numbers that an earlier frame of the sequence has chosen, if there is one.
RenderSettings with_numbers_of_sequence(RenderSettings asked, const JobMaps* maps) {
  if (!maps || !maps->numbers) return asked;
  asked.photons = maps->numbers->photons;
  asked.nearest = maps->numbers->nearest;
  asked.gather = maps->numbers->gather;
  asked.light_samples = maps->numbers->light_samples;
  return asked;
}

/// Rows in the middle of the picture that show what it takes to finish it.
PixelBounds rehearsed_part(const PixelBounds& all) {
  const int rows = std::min(std::max(static_cast<int>(all.height() * kPilotShare), 32), all.height());
  const int first = all.y0 + (all.height() - rows) / 2;
  return {all.x0, first, all.x1, first + rows};
}

/// Whether another process has the picture.
bool helps(const std::shared_ptr<Ranks>& ranks) { return ranks && ranks->rank() > 0; }

/// Bytes of a film, of a copy of it, and of a part that is rehearsed.
std::uint64_t film_bytes(const RenderSettings& s, std::uint32_t batches, bool helps) {
  if (helps) return 0;
  const auto bytes = [&](const PixelBounds& bounds) {
    return Film::bytes(bounds, s.separate_layers, s.place_layers(), filters(s), s.light_group_count, batches);
  };
  return 2 * bytes(s.bounds) + (s.time_limit_s > 0 ? bytes(rehearsed_part(s.bounds)) : 0);
}

std::uint64_t image_bytes(const RenderSettings& s, bool helps) { return helps ? 0 : image_bytes(s); }

/// Bytes of the arrays of a render, and of its smallest task.
std::uint64_t bytes_of(const RenderSettings& s, std::uint32_t batches, bool helps) {
  const std::uint64_t photons = s.photon_target > 0 ? std::max(s.photons, kMostPhotonsForNoise) : s.photons;
  const bool guides = s.integrator == Integrator::gather && s.gather_guiding;
  const bool narrow = s.extrapolates || s.place_layers().values.has(SlotValue::bias);
  const double pixels = static_cast<double>(s.width) * s.height;
  const std::uint64_t guiding =
      guides ? std::max(bright_patch_bytes(photons), gather_guide_bytes(pixels, s.gather, s.of_points)) : 0;
  return film_bytes(s, batches, helps) + image_bytes(s, helps) + photons * bytes_per_photon(s.media, narrow) + guiding +
         smallest_room(s);
}

/// The film of the picture; of one that another process has, none of its pixels.
Film film_of(const RenderSettings& s, std::uint32_t batches, const DiskMemory* disk, bool helps) {
  const DiskMemory::Scope scope(disk);
  return Film(helps ? PixelBounds() : s.bounds, s.indirect_only, s.separate_layers, s.place_layers(), filters(s),
              s.light_group_count, {batches, s.sample_range().first});
}

}  // namespace

Job::Job(std::shared_ptr<const Scene> scene, std::shared_ptr<const Tracer> tracer, const RenderSettings& asked,
         const Checkpoint* resume, JobEnd end, std::shared_ptr<const PointGrid> points, std::shared_ptr<Ranks> ranks,
         std::shared_ptr<JobMaps> maps)
    : scene_(std::move(scene)),
      tracer_(std::move(tracer)),
      points_(std::move(points)),
      settings_(resolve(settings_for(resume ? with_numbers_of(asked, parse_key(resume->key))
                                            : with_numbers_of_sequence(asked, maps.get()),
                                     points_.get()),
                        *scene_)),
      automatic_(resume ? AutomaticNumbers() : automatic_numbers(asked)),
      light_groups_(settings_.light_groups ? std::make_shared<const LightGroups>(glowworm::light_groups(*scene_))
                                           : nullptr),
      budget_(settings_.memory_bytes),
      disk_(
          DiskMemory::for_arrays(settings_.disk, bytes_of(settings_, batches(), helps(ranks)), settings_.memory_bytes)),
      film_memory_(array_budget(), "film", film_bytes(settings_, batches(), helps(ranks))),
      film_(film_of(settings_, batches(), disk_.get(), helps(ranks))),
      start_(std::chrono::steady_clock::now()),
      job_end_(std::move(end)),
      time_(settings_.time_limit_s, job_end_.spent_s, [this] { return seconds(); }),
      owns_maps_(!maps),
      made_(maps ? std::move(maps) : std::make_shared<JobMaps>(array_budget())),
      ranks_(std::move(ranks)) {
  for (const std::string& name : settings_.guide_cameras) guide_cameras_.push_back(&scene_->camera(name));
  if (!job_end_.earlier.empty()) earlier_.emplace(frame_view(), std::move(job_end_.earlier));
  // Photons in media take an index of their own.
  const std::uint64_t arrays = bytes_of(settings_, batches(), false);
  if (settings_.scene_moves && !settings_.progressive && !disk_ && arrays < settings_.memory_bytes)
    most_kept_bytes_ = (settings_.memory_bytes - arrays) / 4;
  const bool has_room = scene_->media().empty() || (!disk_ && 2 * arrays <= settings_.memory_bytes);
  const bool chooses = settings_.photon_target > 0, states = settings_.noise_target > 0 || has_room;
  measures_photon_noise_ = !points_ && !settings_.progressive && settings_.sample_range().first == 0 &&
                           (chooses || (states && !helps(ranks_)));
  if (made_->photon_variance) {
    photon_variance_ = *made_->photon_variance;
    measures_photon_noise_ = false;
  }
  if (disk_) disk_pages_.emplace(budget_, "pages of arrays on disk", settings_.memory_bytes / 2);
  if (ranks_ && ranks_->rank() == 0) crew_ = std::make_unique<Crew>(ranks_);
  if (made_->rows) {
    film_.take_rows(*made_->rows);
    film_.add_not_finite(made_->rows->not_finite());
    made_->rows.reset();
    passes_ = film_.whole_passes();
  }
  if (const std::shared_ptr<const EarlierWork> earlier = std::exchange(made_->earlier, nullptr)) {
    statistics_.add(earlier->statistics);
    earlier_lights_ = earlier->lights;
    tasks_ = earlier->tasks;
    photon_map_bytes_ = earlier->photon_map_bytes;
    query_point_bytes_ = earlier->query_point_bytes;
  }
  if (resume && !helps(ranks_)) this->resume(*resume);
  made_->maps.reserve_in(&array_budget());
  if (!settings_.share.empty() && settings_.integrator != Integrator::path)
    shared_ = std::make_unique<ShareFolder>(settings_.share, key_text(key_of_photons(key())));
  earlier_peak_ = peak_resident_bytes();
  return_free_memory();
  scene_bytes_ = resident_bytes();
  restart_peak_resident();
  thread_ = std::thread([this] { run(); });
}

Job::~Job() {
  cancel();
  if (thread_.joinable()) thread_.join();
  made_->maps.reserve_in(nullptr);
}

void Job::wait() {
  const std::lock_guard lock(join_mutex_);
  if (thread_.joinable()) thread_.join();
  if (failure_) std::rethrow_exception(failure_);
}

bool Job::wait_for(double seconds) const {
  std::unique_lock lock(done_mutex_);
  return done_changes_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return done_.load(); });
}

double Job::seconds() const {
  if (done_) return end_seconds_;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

double Job::progress() const {
  if (done_) return 1;
  const double by_time = time_.is_set() ? seconds() / std::max(time_.whole_s(), 1e-9) : 0;
  return std::clamp(std::max<double>(by_time, work_done_), 0.0, 1.0);
}

std::shared_ptr<JobMaps> Job::maps_for_next_slice() const {
  made_->rows = film_;
  made_->photon_variance = photon_variance_;
  auto earlier = std::make_shared<EarlierWork>();
  earlier->statistics.add(statistics_);
  earlier->lights = light_photons();
  earlier->tasks = tasks_;
  earlier->photon_map_bytes = photon_map_bytes_;
  earlier->query_point_bytes = query_point_bytes_;
  made_->earlier = std::move(earlier);
  return made_;
}

void JobMaps::change_scene(JobGuides learned) {
  maps.forget();
  static_cast<JobGuides&>(*this) = std::move(learned);
}

Film Job::snapshot() const {
  const DiskMemory::Scope scope(disk_.get());
  const std::lock_guard lock(film_mutex_);
  return film_;
}

Checkpoint Job::checkpoint() const {
  std::string key = key_text(this->key());
  const DiskMemory::Scope scope(disk_.get());
  const std::lock_guard lock(film_mutex_);
  return {std::move(key), film_.whole_passes(), film_.save(), round_, photon_variance_};
}

std::vector<LightPhotons> Job::light_photons() const {
  const std::lock_guard lock(film_mutex_);
  return light_photons_.empty() ? earlier_lights_ : light_photons_;
}

double Job::mean_samples() const {
  const std::lock_guard lock(film_mutex_);
  return film_.mean_samples();
}

std::uint64_t Job::samples_not_finite() const {
  const std::lock_guard lock(film_mutex_);
  return film_.not_finite();
}

FrameView Job::frame_view() const {
  const RenderSettings s = settings();
  return {scene_->camera(s.camera), s.width, s.height, s.bounds};
}

RenderKey Job::key() const {
  const std::lock_guard lock(key_mutex_);
  if (!key_) {
    key_ = render_key(*scene_, settings(), points_.get());
    const std::string& first = made_->first_moment;
    if (!first.empty() && first != hash_of_moment(*key_)) key_->push_back({"first moment", first});
  }
  return *key_;
}

RenderSettings Job::settings() const {
  const std::lock_guard lock(settings_mutex_);
  return settings_;
}

void Job::resume(const Checkpoint& checkpoint) {
  check_same_render(key(), parse_key(checkpoint.key), "the checkpoint");
  if (!film_.restore(checkpoint.film) || film_.whole_passes() != checkpoint.passes)
    throw Error("the checkpoint is corrupt: its sums are invalid", "Remove the file to start again.");
  if (!settings_.part.is_all() && film_.most_samples() > settings_.sample_range().count())
    throw Error("the checkpoint holds samples that do not belong to the part",
                "Give the same --part again, or remove the file to start again.");
  if (!checkpoint.round.empty() && !is_round_of(settings_.bounds, checkpoint.round))
    throw Error("the checkpoint is corrupt: its numbers of samples are invalid", "Remove the file to start again.");
  if (!is_variance(checkpoint.photon_variance))
    throw Error("the checkpoint is corrupt: its noise of photons is invalid", "Remove the file to start again.");
  photon_variance_ = checkpoint.photon_variance;
  passes_ = checkpoint.passes;
  round_ = checkpoint.round;
}

std::uint64_t Job::peak_beside_scene_bytes() const {
  const std::uint64_t peak = peak_resident_bytes();
  return peak > scene_bytes_ ? peak - scene_bytes_ : 0;
}

std::uint64_t Job::peak_resident() const { return std::max(earlier_peak_, peak_resident_bytes()); }

void Job::run() {
  try {
    const PhaseTimer timer(statistics_, Phase::other);
    const Reservation image(array_budget(), "image", image_bytes(settings_, helps(ranks_)));
    ranks_ && !crew_ ? work_for_rank_0() : render_passes();
  } catch (const Cancelled&) {
    ending_ = Ending::cancelled;
  } catch (...) {
    failure_ = std::current_exception();
    ending_ = Ending::failed;
  }
  if (crew_) crew_->stop(1);
  end_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  statistics_.add_time(Phase::total, end_seconds_);
  {
    const std::lock_guard lock(done_mutex_);
    done_ = true;
  }
  done_changes_.notify_all();
}

bool Job::should_stop(double next_s) {
  if (time_.wants_rehearsal(passes_ > 0)) rehearse();
  if (interrupt_.requested())
    ending_ = Ending::cancelled;
  else if (passes_ >= job_end_.least_passes && time_.is_up(next_s))
    ending_ = Ending::time_up;
  return ending_ != Ending::running;
}

void Job::rehearse() {
  const PhaseTimer timer(statistics_, Phase::filter);
  const DiskMemory::Scope scope(disk_.get());
  const PixelBounds rows = rehearsed_part(settings_.bounds);
  const Film part = [&] {
    const std::lock_guard lock(film_mutex_);
    return film_.sketch_of_rows(rows.y0, rows.y1);
  }();
  time_.rehearse(passes_ > 0, 1.0 * rows.height() / settings_.bounds.height(),
                 [&] { job_end_.rehearsal ? job_end_.rehearsal(part, *this) : void(shown_picture(part, settings_)); });
}

double Job::noise_of_samples() const { return noise_left_to_samples(settings_.noise_target, photon_variance_); }

bool Job::knows_noise() const {
  if (batches() == 1) return true;
  const std::uint32_t passes = film_.whole_passes(), batches_begun = std::min(passes, batches());
  const std::uint64_t degrees = film_.pixel_count() * std::uint64_t{batches_begun - 1};
  // A variance of 16 degrees of freedom is known to a third. Those of few points are known when all batches have
  // samples.
  if (settings_.integrator != Integrator::path) return batches_begun == batches() || degrees >= 16;
  // Few paths may all miss a lobe or a lamp, and then agree; those of many sensors may miss the same one. So each
  // sensor takes kLeastPaths. The error of few sensors is tested only at powers of two, where their sequences fill
  // space evenly: at other counts it fluctuates, and a low value by chance would end the render.
  constexpr std::uint32_t kLeastPaths = 256, kManyDegrees = 64;
  return passes >= kLeastPaths && (degrees >= kManyDegrees || std::has_single_bit(passes));
}

bool Job::reached_noise_target() {
  if (!(settings_.noise_target > 0) || !tests_noise_after(passes_, filters(settings_)) || !knows_noise()) return false;
  const PhaseTimer timer(statistics_, Phase::filter);
  const DiskMemory::Scope scope(disk_.get());
  if (relative_error(measured_picture()) > noise_of_samples()) return false;
  ending_ = Ending::noise_reached;
  return true;
}

PassSettings Job::pass_settings() {
  const RenderSettings& s = settings_;
  PassSettings pass;
  pass.kind = s.integrator == Integrator::photons ? PassKind::photons : PassKind::gather;
  pass.width = s.width;
  pass.height = s.height;
  pass.gather = s.gather;
  pass.light_samples = s.light_samples;
  pass.seed = s.sample_seed();
  pass.places = s.place_layers().of_triangles();
  pass.values = s.place_layers().values;
  pass.surface_samples = s.place_layers().surface_samples;
  if (pass.surface_samples && !edges_) edges_.emplace(s.width, s.height);
  pass.edges = edges_ ? &*edges_ : nullptr;
  pass.direct = pass.caustic = !s.indirect_only;
  pass.secondary_gather = s.secondary_gather;
  pass.extrapolates = s.extrapolates;
  pass.patches = s.gather_guiding;
  pass.guide = &made_->gather_guide;
  pass.light_groups = light_groups_.get();
  return pass;
}

View Job::view() const {
  if (points_) return *points_;
  return scene_->camera(settings_.camera);
}

View Job::guide_view() const { return guide_cameras_.empty() ? view() : View(std::span(guide_cameras_)); }

PassSettings Job::guide_pass() const {
  PassSettings pass = pass_;
  pass.seed = settings_.seed;
  return pass;
}

void Job::prepare(std::uint32_t done) {
  if (mapped_ && (!settings_.progressive || mapped_ == done)) return;
  if (settings_.photons > 0) shoot_photons(settings_.sample_range().first + done);
  mapped_ = done;
  schedule_ = make_schedule(settings_, budget_.available());
  pass_.queries_at_once = schedule_.queries_at_once;
  pass_.by_disk = schedule_.by_disk;
}

void Job::render_passes() {
  pass_ = pass_settings();
  if (crew_) crew_->check(key());
  const std::uint32_t first_pass = passes_;
  // Other processes measure other times.
  const bool alone = !crew_ && !shared_ && settings_.part.is_all();
  if (settings_.integrator != Integrator::path && first_pass == 0 && owns_maps_ && alone) fit_to_time();
  if (settings_.only_maps) {
    prepare(first_pass);
    made_->first_moment = hash_of_moment(key());
    ending_ = Ending::samples_done;
    return;
  }
  const bool adaptive = is_adaptive(settings_);
  // The checkpoint may have been written after the last pass but before its noise test.
  if (first_pass > 0 && !adaptive && film_.is_even() && reached_noise_target()) return;
  const std::uint32_t all = settings_.sample_range().count(), first = settings_.sample_range().first;
  const std::uint32_t end = adaptive ? std::min(kEvenSamples, all) : settings_.slice_range().end - first;
  for (std::uint32_t done = first_pass; done < end; done = passes_) {
    if (should_stop(settings_.progressive ? photon_seconds_ + task_seconds_ : task_seconds_)) return;
    prepare(done);
    std::uint32_t samples = std::min(samples_of_pass(schedule_, settings_, done), end - done);
    if (crew_ && !settings_.progressive && !(settings_.noise_target > 0)) samples = end - done;
    const WorkShare share{double{1} * done / all, (double{1} * done + samples) / all};
    if (!(crew_ ? share_pass(done, samples, share)
                : render_tasks(tasks_of_pass(schedule_, settings_, done, samples), share)))
      return;
    passes_ = done + samples;
    if (!adaptive && reached_noise_target()) return;
  }
  if (adaptive)
    render_rounds();
  else
    ending_ = Ending::samples_done;
}

SquareSamples Job::choose_round(double& choice_s, WorkShare& share) {
  const PhaseTimer timer(statistics_, Phase::filter);
  const DiskMemory::Scope scope(disk_.get());
  const double target = noise_of_samples(), start = seconds();
  const std::uint32_t most = settings_.sample_range().count();
  // A choice pays only if samples follow, so it may take a quarter of the time left.
  SquareSamples next;
  if (choice_s > 0.25 * time_.left_s()) {
    next = even_round(film_, most);
  } else {
    const FilmPicture seen = measured_picture();
    const double error = relative_error(seen);
    if (target > 0 && error <= target && knows_noise()) {
      ending_ = Ending::noise_reached;
      return {};
    }
    next = next_round(film_, seen, target, most);
    // The square of the error falls in proportion to the work.
    share.begin = target > 0 ? target * target / (error * error) : 0;
    share.end = std::min(share.begin * (1 + kRoundGrowth), 1.0);
    choice_s = seconds() - start;
  }
  if (next.empty()) ending_ = Ending::samples_done;
  return next;
}

void Job::render_rounds() {
  WorkShare share{0, 0};
  in_rounds_ = true;
  double choice_s = time_.finish_s();  // Nearly all of a choice is the filter.
  while (!should_stop(0)) {
    if (round_.empty()) {
      SquareSamples next = choose_round(choice_s, share);
      if (ending_ != Ending::running) return;
      const std::lock_guard lock(film_mutex_);
      round_ = std::move(next);
    }
    prepare(passes_);
    std::vector<CameraTask> tasks = tasks_of_round(film_, round_);
    const std::uint32_t most_at_once =
        std::min(kSharedSlots / (CameraTask::kBlock * CameraTask::kBlock), most_shared_samples(settings_));
    const bool whole = crew_ ? share_tasks(tasks, most_at_once, share) : render_tasks(std::move(tasks), share);
    const std::lock_guard lock(film_mutex_);
    passes_ = film_.whole_passes();
    if (!whole) return;
    round_.clear();
  }
}

bool Job::render_tasks(std::vector<CameraTask> tasks, WorkShare share) {
  const double slots = static_cast<double>(CameraTasks(tasks).slot_count());
  for (CameraTask& task : tasks) task.y0 = film_.first_row_to_do(task);
  std::erase_if(tasks, [](const CameraTask& task) { return task.y0 == task.y1; });
  double slots_left = static_cast<double>(CameraTasks(tasks).slot_count());
  std::reverse(tasks.begin(), tasks.end());
  while (!tasks.empty()) {
    const std::vector<CameraTask> places = next_tasks(tasks, schedule_.slots_at_once, time_.task_s(), slot_seconds_);
    const auto slots_here = static_cast<double>(CameraTasks(places).slot_count());
    if (should_stop(slot_seconds_ * slots_here)) return false;
    put(places, compute(places));
    slots_left -= slots_here;
    work_done_ = std::lerp(share.end, share.begin, slots_left / slots);
  }
  return true;
}

Job::TaskResult Job::compute(CameraTasks places) {
  const double start = seconds();
  // The film counts the samples of the range; random numbers belong to their index in the whole render.
  std::vector<CameraTask> tasks(places.begin(), places.end());
  for (CameraTask& task : tasks) task.first_sample += settings_.sample_range().first;
  TaskResult out;
  if (light_groups_) name_groups(*light_groups_, out.radiance);
  if (settings_.integrator == Integrator::path) {
    const PhaseTimer timer(statistics_, Phase::trace_paths);
    trace_paths(*tracer_, view(), tasks, settings_, settings_.photons > 0 ? &made_->maps : nullptr, out.radiance,
                out.first_hit, statistics_);
  } else {
    PassResult result = render_pass(*tracer_, made_->maps, view(), tasks, pass_, budget_, memory_, statistics_);
    out.radiance = std::move(result.radiance);
    out.first_hit = std::move(result.first_hit);
  }
  {
    const PhaseTimer timer(statistics_, Phase::completion);
    out.not_finite = drop_infinite_samples(out.radiance);
  }
  query_point_bytes_ = memory_.most_query_bytes;
  task_seconds_ = seconds() - start;
  slot_seconds_ = task_seconds_ / static_cast<double>(places.slot_count());
  return out;
}

void Job::add_samples(Film& film, CameraTasks places, const TaskResult& result) const {
  std::size_t first_slot = 0;
  for (const CameraTask& place : places) {
    film.add(place, result.radiance, result.first_hit, scene_->geometry(), first_slot);
    first_slot += place.slot_count();
  }
  film.add_not_finite(result.not_finite);
}

void Job::put(CameraTasks places, const TaskResult& result) {
  ++tasks_;
  const PhaseTimer timer(statistics_, Phase::completion);
  const std::lock_guard lock(film_mutex_);
  // Two ranks may have computed them.
  if (std::all_of(places.begin(), places.end(), [&](const CameraTask& place) { return film_.has(place); })) return;
  add_samples(film_, places, result);
}

void Job::put(const CameraTask& task, const Film& film) {
  ++tasks_;
  const std::lock_guard lock(film_mutex_);
  if (!film_.has(task)) film_.add(task, film);
}

}  // namespace glowworm
