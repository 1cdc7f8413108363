#include "apps/render_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "apps/table_options.h"
#include "control/job_report.h"
#include "core/log.h"
#include "film/checkpoint.h"
#include "film/filtered.h"
#include "maps/photon_noise.h"
#include "session/command_text.h"
#include "settings/effects.h"
#include "settings/settings.h"

namespace glowworm {

namespace {

using Clock = std::chrono::steady_clock;

/// @param asked settings before those left to the program were chosen
std::string describe(const RenderSettings& asked, const RenderSettings& s, const Scene& scene) {
  std::string text =
      fmt::format("{}: {} triangles, {}x{} pixels", scene.name(), scene.geometry().triangle_count(), s.width, s.height);
  if (s.bounds != PixelBounds{0, 0, s.width, s.height})
    text += fmt::format(" (only {}x{} at {},{})", s.bounds.width(), s.bounds.height(), s.bounds.x0, s.bounds.y0);
  const SampleRange range = s.sample_range();
  const bool open_ended = asked.samples == 0 && (s.time_limit_s > 0 || s.noise_target > 0);
  text += open_ended        ? ", unlimited samples"
          : s.part.is_all() ? fmt::format(", {} samples", s.samples)
                            : fmt::format(", samples {} to {} of {}", range.first + 1, range.end, s.samples);
  if (s.integrator == Integrator::path)
    return text + ", path tracing" +
           (s.photons > 0 ? fmt::format(", {} photons a sample for lights that mirrors or glass bend", s.photons) : "");
  if (s.integrator == Integrator::gather) text += fmt::format(" x {} gather rays", s.gather);
  text += fmt::format(", {} photons", s.photons);
  if (s.thinned > 0) text += fmt::format(" thinned to {}", s.thinned);
  return text + fmt::format(", k = {}, engine {}", s.nearest, s.engine);
}

/// Computes tasks until rank 0 ends the render.
void help_rank_0(Job& job) {
  while (!job.done()) {
    if (caught_interrupt()) job.cancel();
    job.wait_for(0.02);
  }
  job.wait();
}

/// Sets the samples that the next try needs.
void look_ahead(BlurGoal& goal, const Job& job) {
  const Clock::time_point now = Clock::now();
  constexpr double kLeastGrowth = 1.25;  // a smaller one is not worth another try
  double growth = Film::kMaxSamples;
  goal.next = 0;
  if (goal.noise > 0) {
    const double error = relative_error(shown_picture(job.film(), job.settings()));
    const double wanted = noise_left_to_samples(goal.noise, job.photon_variance());
    if (error <= wanted) return;
    growth = std::max(1.1 * error * error / (wanted * wanted), kLeastGrowth);
  }
  if (goal.end_s > 0)
    growth = std::min(growth, (goal.end_s - seconds_between(goal.start, now)) / seconds_between(goal.begun, now));
  const double next = std::min(goal.samples * growth, 1.0 * goal.most);
  if (next >= kLeastGrowth * goal.samples) goal.next = static_cast<std::uint32_t>(next);
}

/// The checkpoint of --resume; its key alone, of a rank that helps; nothing if there is none, or a job before has gone
/// on from it.
std::optional<Checkpoint> checkpoint_of(const RenderOptions& o, bool helps, Kept* kept) {
  // All ranks continue with its numbers of photons and rays. Of the slices of time, the first continues.
  if (o.resume.empty() || (kept && std::exchange(kept->is_resumed, true))) return std::nullopt;
  if (helps) return read_key_of_checkpoint(o.resume);
  std::optional<Checkpoint> checkpoint = read_checkpoint(o.resume, o.settings.disk, o.settings.memory_bytes);
  if (checkpoint) inform(fmt::format("going on from {}, which holds {} passes", o.resume, checkpoint->passes));
  return checkpoint;
}

/// Prints what is rendered: once, before the first samples.
void describe_once(const RenderOptions& o, const Job& job, const Scene& scene, Kept* kept, Purpose purpose) {
  if (purpose == Purpose::maps || (kept && std::exchange(kept->is_described, true))) return;
  RenderSettings whole = job.settings();
  if (purpose == Purpose::share) whole.part = {};
  inform(describe(o.table.settings, whole, scene));
  for (const std::string& note : choice_notes(o.table.settings, job.settings())) detail("chosen: " + note);
  for (const std::string& note : effect_notes(scene, job.settings())) inform("note: " + note);
}

/// Keeps what a job leaves to the next one. Returns whether this is all that it is for: if not, its picture is written.
/// Throws the job's failure, or Cancelled, if others need what it should have made.
bool keep_for_next(const RenderOptions& o, Job& job, Kept& kept, Purpose purpose, const std::exception_ptr& failure) {
  const bool whole = !failure && job.ending() == Ending::samples_done;
  if (purpose == Purpose::maps || purpose == Purpose::share) {
    if (failure) std::rethrow_exception(failure);
    if (!whole) throw Cancelled();
  }
  if (purpose == Purpose::maps) {
    kept.maps = job.maps();
    auto learned = std::make_shared<Statistics>();
    learned->add(job.statistics());
    kept.learning = std::move(learned);
    return true;
  }
  if (purpose == Purpose::share || (purpose == Purpose::slice && whole)) {
    kept.maps = job.maps_for_next_slice();
    return true;
  }
  if (purpose == Purpose::picture && kept.goal && whole) {
    look_ahead(*kept.goal, job);
    if (kept.goal->next > 0) {
      kept.maps = job.maps();
      return true;
    }
  }
  if (o.sequence.reuse > 0 && !failure) kept.light = std::make_shared<const FrameLight>(frame_light(job));
  if (purpose != Purpose::light || failure || job.ending() == Ending::cancelled) return false;
  kept.maps = job.maps();
  return true;
}

}  // namespace

Opened open_render(RenderOptions& o, OutputFiles& files, bool helps, std::shared_ptr<SceneMotion> motion) {
  Opened out;
  out.start = Clock::now();
  out.import.budget = loading_budget(o.settings.memory_bytes);
  if (motion) out.import.textures = texture_library(out.import.budget);
  if (motion && !(motion->is_still && motion->slice_count() == 0)) out.import.gltf = gltf_reader();
  ImportOptions import_options = out.import;
  import_options.motion = std::move(motion);
  out.scene = open_scene(o.scene, import_options, o.changes.changes, &files);
  if (!o.lights.empty()) out.named = std::make_shared<const LightRig>(out.scene);
  read_command_line([&] {
    out.scene = scene_of_view(out.scene, o.lights, o.view, o.settings.camera);
    const PixelBounds bounds = resolve(o.settings, *out.scene).bounds;
    if (!helps && !o.settings.bounds.empty() && bounds != o.settings.bounds)
      warn(fmt::format("--pixel-bounds reaches beyond the picture: only {},{},{},{} is rendered", bounds.x0, bounds.y0,
                       bounds.x1, bounds.y1));
  });
  const Clock::time_point loaded = Clock::now();
  out.load_s = seconds_between(out.start, loaded);
  if (!helps) tell_notes(*out.scene, o.scene);
  out.tracer = std::make_shared<const Tracer>(*out.scene);
  out.build_s = seconds_between(loaded, Clock::now());
  return out;
}

void dismiss_ranks(Crew& crew, Ranks& ranks, int status) {
  constexpr double kSeconds = 60;
  const bool all = crew.dismiss(kSeconds);
  for (const std::string& failure : crew.failures()) warn(failure);
  if (all) return;
  warn("ranks that do not answer are ended. If mpirun waits for their machines, end it: all files are written");
  ranks.abort(status);
}

int render_picture(const RenderOptions& o, const Opened& opened, OutputFiles& files, TevStream& tev,
                   const std::shared_ptr<Ranks>& ranks, Kept* kept, Purpose purpose) {
  const bool helps = ranks && ranks->rank() > 0;
  std::optional<Checkpoint> checkpoint = checkpoint_of(o, helps, kept);
  const auto rehearsal = [&o](const Film& film, const Job& job) { rehearse_images(o, film, job); };
  const std::shared_ptr<const Statistics> learning = kept ? std::exchange(kept->learning, nullptr) : nullptr;
  const double spent_s = learning ? learning->seconds(Phase::total) : 0;
  const FrameLights tested(o.earlier.end() - static_cast<std::ptrdiff_t>(o.tested), o.earlier.end());
  Job job(opened.scene, opened.tracer, o.settings, checkpoint ? &*checkpoint : nullptr, {spent_s, rehearsal, 1, tested},
          nullptr, ranks, kept ? kept->maps : nullptr);
  checkpoint.reset();
  if (helps) {
    help_rank_0(job);
    return 0;
  }
  if (learning) job.statistics().add(*learning);
  job.statistics().add_time(Phase::load, opened.load_s);
  job.statistics().add_time(Phase::build_accel, opened.build_s);
  describe_once(o, job, *opened.scene, kept, purpose);
  const std::exception_ptr failure = attend(job, o.report.quiet,
                                            {{1, [&] { keep_checkpoint(o, job, files, purpose == Purpose::slice); }},
                                             {2, [&] { keep_preview(o, job, files); }},
                                             {0.25, [&] { tev.show(job); }}},
                                            purpose == Purpose::share ? kept->part : WorkPart());
  if (kept && keep_for_next(o, job, *kept, purpose, failure)) return 0;
  const int status = finish_render(o, job, *opened.tracer, files, opened.start, failure);
  tev.show(job);
  if (ranks) dismiss_ranks(*job.crew(), *ranks, status);
  if (kept) kept->maps = job.maps();
  return status;
}

}  // namespace glowworm
