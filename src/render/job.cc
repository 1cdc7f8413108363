#include "render/job.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "render/output.h"
#include "render/path_tracer.h"
#include "render/photon_renderer.h"

namespace glowworm {

namespace {

/// Side of a tile in pixels: a task of this size fills both cores with work and is done in a moment.
constexpr int kTile = 256;
/// Factor on the radii in a pass of progressive photon mapping: r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1) (Knaus and
/// Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", 2011, equation 20), with alpha = 2/3.
float progressive_radius_scale(std::uint32_t pass) {
  constexpr double alpha = 2.0 / 3.0;
  double squared = 1;
  for (std::uint32_t i = 1; i <= pass; ++i) squared *= (i + alpha) / (i + 1);
  return static_cast<float>(std::sqrt(squared));
}

std::vector<CameraTask> make_tasks(const RenderSettings& settings, std::uint32_t sample) {
  std::vector<CameraTask> tasks;
  for (int y = 0; y < settings.height; y += kTile)
    for (int x = 0; x < settings.width; x += kTile)
      tasks.push_back({x, y, std::min(x + kTile, settings.width), std::min(y + kTile, settings.height), sample, 1});
  return tasks;
}

}  // namespace

Job::Job(std::shared_ptr<const Scene> scene, std::shared_ptr<const Tracer> tracer, const RenderSettings& asked,
         const Checkpoint* resume)
    : scene_(std::move(scene)),
      tracer_(std::move(tracer)),
      settings_(resolve(asked, *scene_)),
      budget_(settings_.memory_bytes),
      film_(settings_.width, settings_.height),
      start_(std::chrono::steady_clock::now()) {
  if (resume) {
    if (resume->key != key() || !film_.restore(resume->film))
      throw Error("the checkpoint is of another render: its scene, settings or version differ",
                  "Give the options of the render that was cut off, or leave --resume out.");
    passes_ = film_.whole_passes();
  }
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
  const double by_time = settings_.time_limit_s > 0 ? seconds() / settings_.time_limit_s : 0;
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

std::string Job::key() const {
  RenderSettings s = settings_;
  // What may differ between the runs that make one image; more samples go on where fewer ended.
  s.samples = 0;
  s.noise_target = 0;
  s.threads = 0;
  s.memory_bytes = 0;
  s.time_limit_s = 0;
  return std::string(version()) + " " + scene_->name() + " " + std::to_string(scene_->geometry().triangle_count()) +
         " " + settings_text(s);
}

void Job::run() {
  try {
    const Reservation film(budget_, "film", Film::bytes(settings_.width, settings_.height));
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

bool Job::should_stop() {
  if (cancelled_)
    ending_ = Ending::cancelled;
  else if (settings_.time_limit_s > 0 && passes_ > 0 && seconds() >= settings_.time_limit_s)
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
  photons.shoot_photons(settings_.progressive ? pass : 0,
                        settings_.progressive ? progressive_radius_scale(pass) : 1.0f);
  photon_map_bytes_ = photons.photon_bytes();
}

void Job::render_passes() {
  const Camera& camera = scene_->camera(settings_.camera);
  PhotonRenderer photons(*tracer_, settings_, budget_, statistics_);
  const bool mapped = settings_.integrator != Integrator::path;
  const std::uint32_t first_pass = passes_;
  // A render may have been cut off between its last pass and the look at its noise.
  if (first_pass > 0 && film_.is_even() && reached_noise_target()) return;
  for (std::uint32_t pass = first_pass; pass < settings_.samples; ++pass) {
    if (should_stop()) return;
    if (mapped && (pass == first_pass || settings_.progressive)) shoot_photons(photons, pass);
    const std::vector<CameraTask> tasks = make_tasks(settings_, pass);
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (film_.has(tasks[i])) continue;
      if (should_stop()) return;
      SlotRadiance radiance;
      FirstHit first_hit;
      if (mapped)
        photons.render(camera, tasks[i], radiance, first_hit);
      else
        trace_paths(*tracer_, camera, tasks[i], settings_, radiance, first_hit, statistics_);
      query_point_bytes_ = photons.query_bytes();
      const std::lock_guard lock(film_mutex_);
      film_.add(tasks[i], radiance, first_hit);
      work_done_ = (pass + static_cast<double>(i + 1) / static_cast<double>(tasks.size())) / settings_.samples;
    }
    passes_ = pass + 1;
    if (reached_noise_target()) return;
  }
  ending_ = Ending::samples_done;
}

}  // namespace glowworm
