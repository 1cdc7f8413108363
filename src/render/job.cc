#include "render/job.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "points/finite_light.h"
#include "render/output.h"
#include "render/path_tracer.h"
#include "render/photon_renderer.h"
#include "render/scheduler.h"

namespace glowworm {

namespace {

// Stands before the memory in the key of a checkpoint.
constexpr const char* kMemoryKey = " memory ";

/// Factor on the radii in a pass of progressive photon mapping: r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1) (Knaus and
/// Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", 2011, equation 20), with alpha = 2/3.
float progressive_radius_scale(std::uint32_t pass) {
  constexpr double alpha = 2.0 / 3.0;
  double squared = 1;
  for (std::uint32_t i = 1; i <= pass; ++i) squared *= (i + alpha) / (i + 1);
  return static_cast<float>(std::sqrt(squared));
}

}  // namespace

Job::Job(std::shared_ptr<const Scene> scene, std::shared_ptr<const Tracer> tracer, const RenderSettings& asked,
         const Checkpoint* resume, double spent_s)
    : scene_(std::move(scene)),
      tracer_(std::move(tracer)),
      settings_(resolve(asked, *scene_)),
      budget_(settings_.memory_bytes),
      film_(settings_.width, settings_.height, settings_.indirect_only, settings_.separate_layers),
      spent_s_(spent_s),
      start_(std::chrono::steady_clock::now()) {
  if (resume) {
    check_checkpoint(*resume);
    if (!film_.restore(resume->film)) throw Error("the checkpoint is of a picture of another size");
    passes_ = film_.whole_passes();
  }
  earlier_peak_ = peak_resident_bytes();
  return_free_memory();
  scene_bytes_ = resident_bytes();
  restart_peak_resident();
  thread_ = std::thread([this] { run(); });
}

Job::~Job() {
  cancel();
  if (thread_.joinable()) thread_.join();
}

void Job::wait() {
  if (thread_.joinable()) thread_.join();
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

double Job::seconds() const {
  if (done_) return end_seconds_;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

double Job::progress() const {
  if (done_) return 1;
  const double by_time = settings_.time_limit_s > 0 ? (spent_s_ + seconds()) / settings_.time_limit_s : 0;
  return std::clamp(std::max<double>(by_time, work_done_), 0.0, 1.0);
}

Film Job::snapshot() const {
  const std::lock_guard lock(film_mutex_);
  return film_;
}

Checkpoint Job::checkpoint() const {
  const std::lock_guard lock(film_mutex_);
  return {key(), film_.whole_passes(), film_.save()};
}

std::vector<LightPhotons> Job::light_photons() const {
  const std::lock_guard lock(film_mutex_);
  return light_photons_;
}

std::string Job::key() const {
  RenderSettings s = settings_;
  // What may differ between the runs that make one image; more samples go on where fewer ended.
  s.samples = 0;
  s.noise_target = 0;
  s.threads = 0;
  s.memory_bytes = 0;
  s.time_limit_s = 0;
  return std::string(version()) + " " + scene_->name() + " " + std::to_string(scene_->geometry().triangle_count()) +
         " " + settings_text(s) + kMemoryKey + std::to_string(memory_shows(settings_) ? settings_.memory_bytes : 0);
}

void Job::check_checkpoint(const Checkpoint& checkpoint) const {
  const std::string own = key(), &other = checkpoint.key;
  if (other == own) return;
  const std::size_t own_end = own.rfind(kMemoryKey), other_end = other.rfind(kMemoryKey);
  if (other_end != std::string::npos && own.substr(0, own_end) == other.substr(0, other_end)) {
    const std::string bytes = other.substr(other_end + std::string_view(kMemoryKey).size());
    throw Error("the checkpoint is of a render with another --memory, which shows in the last bits of the picture",
                "Give --memory " + bytes + ", or leave --resume out.");
  }
  throw Error("the checkpoint is of another render: its scene, settings or version differ",
              "Give the options of the render that was cut off, or leave --resume out.");
}

std::uint64_t Job::peak_beside_scene_bytes() const {
  const std::uint64_t peak = peak_resident_bytes();
  return peak > scene_bytes_ ? peak - scene_bytes_ : 0;
}

std::uint64_t Job::peak_resident() const { return std::max(earlier_peak_, peak_resident_bytes()); }

void Job::run() {
  try {
    const Reservation image(budget_, "image", image_bytes(settings_));
    render_passes();
  } catch (const Cancelled&) {
    ending_ = Ending::cancelled;
  } catch (...) {
    failure_ = std::current_exception();
    ending_ = Ending::failed;
  }
  end_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  statistics_.add_time(Phase::total, end_seconds_);
  done_ = true;
}

bool Job::should_stop(double next_s) {
  // The limit is passed where that comes nearer to it than stopping before it does.
  if (cancelled_)
    ending_ = Ending::cancelled;
  else if (settings_.time_limit_s > 0 && passes_ > 0 && spent_s_ + seconds() + next_s / 2 >= settings_.time_limit_s)
    ending_ = Ending::time_up;
  return ending_ != Ending::running;
}

bool Job::reached_noise_target() {
  if (!(settings_.noise_target > 0) || film_.noise() > settings_.noise_target) return false;
  ending_ = Ending::noise_reached;
  return true;
}

void Job::shoot_photons(PhotonRenderer& photons, std::uint32_t pass) {
  const CancellationScope scope(cancelled_);
  const double start = seconds();
  photons.shoot_photons(settings_.progressive ? pass : 0,
                        settings_.progressive ? progressive_radius_scale(pass) : 1.0f);
  photon_seconds_ = seconds() - start;
  photon_map_bytes_ = photons.photon_bytes();
  const std::lock_guard lock(film_mutex_);
  light_photons_ = photons.light_photons();
}

void Job::render_passes() {
  PhotonRenderer photons(*tracer_, settings_, budget_, statistics_);
  const bool mapped = settings_.integrator != Integrator::path;
  const std::uint32_t first_pass = passes_;
  // A render may have been cut off between its last pass and the look at its noise.
  if (first_pass > 0 && film_.is_even() && reached_noise_target()) return;
  for (std::uint32_t done = first_pass; done < settings_.samples; done = passes_) {
    if (should_stop(settings_.progressive ? photon_seconds_ + task_seconds_ : task_seconds_)) return;
    if (mapped && (done == first_pass || settings_.progressive)) shoot_photons(photons, done);
    const Schedule schedule = make_schedule(settings_, budget_.available());
    photons.set_portions(schedule.queries_at_once, schedule.by_disk);
    const std::uint32_t samples = samples_of_pass(schedule, settings_, done);
    if (!render_pass(photons, tasks_of_pass(schedule, settings_, done, samples))) return;
    passes_ = done + samples;
    if (reached_noise_target()) return;
  }
  ending_ = Ending::samples_done;
}

bool Job::render_pass(PhotonRenderer& photons, const std::vector<CameraTask>& tasks) {
  const Camera& camera = scene_->camera(settings_.camera);
  std::size_t slots = 0, slots_done = 0;
  for (const CameraTask& task : tasks) slots += task.slot_count();
  const double share = static_cast<double>(tasks.front().sample_count) / settings_.samples;
  const double share_done = static_cast<double>(passes_) / settings_.samples;
  for (const CameraTask& task : tasks) {
    slots_done += task.slot_count();
    if (film_.has(task)) continue;
    if (should_stop(task_seconds_)) return false;
    const double start = seconds();
    SlotRadiance radiance;
    FirstHit first_hit;
    if (settings_.integrator == Integrator::path)
      trace_paths(*tracer_, camera, task, settings_, radiance, first_hit, statistics_);
    else
      photons.render(camera, task, radiance, first_hit);
    infinite_samples_ += drop_infinite_samples(radiance);
    query_point_bytes_ = photons.query_bytes();
    paged_counts_ = photons.paged_counts();
    ++tasks_;
    task_seconds_ = seconds() - start;
    const std::lock_guard lock(film_mutex_);
    film_.add(task, radiance, first_hit);
    work_done_ = share_done + share * static_cast<double>(slots_done) / static_cast<double>(slots);
  }
  return true;
}

}  // namespace glowworm
