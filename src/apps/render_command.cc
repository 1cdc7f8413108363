#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>

#include "apps/attend.h"
#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "apps/output_files.h"
#include "apps/picture_output.h"
#include "apps/render_outputs.h"
#include "apps/sequence.h"
#include "apps/table_options.h"
#include "apps/tev_stream.h"
#include "control/job.h"
#include "control/job_report.h"
#include "core/error.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "core/text.h"
#include "film/checkpoint.h"
#include "film/filtered.h"
#include "kernels/simd.h"
#include "maps/photon_noise.h"
#include "session/command_text.h"
#include "settings/effects.h"
#include "settings/settings.h"
#include "share/crew.h"
#include "share/ranks.h"

namespace glowworm {

namespace {

using Clock = std::chrono::steady_clock;

/// Throws CommandLineError for options that do not make a sequence of frames.
void check_sequence(RenderOptions& o) {
  if (o.resumes)
    throw CommandLineError("--resume does not apply to sequences of frames",
                           "Leave it out: frames whose files exist are skipped.");
  if (o.preview)
    throw CommandLineError("--preview does not apply to sequences of frames",
                           "Leave it out: a frame whose file exists counts as finished.");
  if (o.names.empty()) o.names.emplace_back("frame_####.exr");
  for (const std::string& name : o.names)
    if (!has_frame_number(name) || lower_ending(name) == ".part")
      throw CommandLineError(fmt::format("-o {} is no name for the pictures of many frames", name),
                             "Give a name with '#' for the number, such as frame_####.exr.");
  if (!o.report.statistics.empty() && !has_frame_number(o.report.statistics))
    throw CommandLineError(fmt::format("--stats {} is one file for many frames", o.report.statistics),
                           "Give a name with '#' for the number.");
  if (o.sequence.reuse > 0 && !filters(o.settings))
    throw CommandLineError("--reuse has no effect without the filter of gathered light", "Leave it out.");
}

void resolve_options(RenderOptions& o) {
  RenderSettings& s = o.settings;
  s = o.table.settings;
  if (s.memory_bytes == 0) s.memory_bytes = default_memory_bytes() / static_cast<std::uint64_t>(launched_here());
  if (o.picture.illuminance) add_layers_of_illuminance(s.aovs);
  s.separate_layers = !s.aovs.empty();
  read_command_line([&] {
    if (!o.view.empty()) check_view(o.view);
    take_luminaires(o.lights, o.changes.changes);
    for (const std::string& light : o.lights) parse_light_edit(light);
    if (!o.tev.empty()) check_tev_address(o.tev);
    check_part(s);
  });
  o.movie = take_movie(o.names);
  o.sequence.check();
  if (o.sequence.is_given()) check_sequence(o);
  for (const std::string& name : o.names) {
    o.outputs.push_back(output_of(name));
    if (o.outputs.back().format == OutputFormat::part) check_part_output(name, s);
  }
  o.picture.color.load();
}

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

/// Ends the other ranks. Those that do not answer are aborted.
void dismiss_ranks(Job& job, Ranks& ranks, int status) {
  constexpr double kSeconds = 60;
  const bool all = job.crew()->dismiss(kSeconds);
  for (const std::string& failure : job.crew()->failures()) warn(failure);
  if (all) return;
  warn("ranks that do not answer are ended. If mpirun waits for their machines, end it: all files are written");
  ranks.abort(status);
}

/// A scene, ready to render.
struct Opened {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;
  Clock::time_point start;  ///< of the render
  double load_s = 0, build_s = 0;
  ImportOptions import;  ///< of other moments
};

/// Loads the scene of the command line, in its view and light.
/// @param motion to import with it; null: none
Opened open(RenderOptions& o, OutputFiles& files, bool helps, std::shared_ptr<SceneMotion> motion) {
  Opened out;
  out.start = Clock::now();
  out.import.budget = loading_budget(o.settings.memory_bytes);
  if (motion) out.import.textures = texture_library(out.import.budget);
  ImportOptions import_options = out.import;
  import_options.motion = std::move(motion);
  out.scene = open_scene(o.scene, import_options, o.changes.changes, &files);
  read_command_line([&] {
    out.scene = scene_of_view(out.scene, o.lights, o.view, o.settings.camera);
    const PixelBounds bounds = resolve(o.settings, *out.scene).bounds;
    if (!o.settings.bounds.empty() && bounds != o.settings.bounds)
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

/// When a picture with motion blur has enough samples: its slices of time share a number that is known before.
struct BlurGoal {
  double noise = 0, end_s = 0;      ///< --noise, and --time from `start`; 0: not asked for
  Clock::time_point start, begun;   ///< of the first try, and of this one
  std::uint32_t samples = 0, most;  ///< of this try, and of any
  std::uint32_t next = 0;           ///< of the next one; 0: this one is enough
};

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

/// What a job leaves to later ones.
struct Kept {
  std::optional<BlurGoal> goal;             ///< of the picture that the jobs render
  std::shared_ptr<JobMaps> maps;            ///< null: none
  std::shared_ptr<const FrameLight> light;  ///< of a frame, if any uses light again
};

/// What becomes of the samples of a job that does not end early: a picture, those of a picture's next slice of time, or
/// the light of a frame alone.
enum class Purpose { picture, slice, light };

/// Renders one picture, and returns the exit status.
/// @param ranks that share the work; null: this process alone
/// @param kept of the job before, and then of this one; null: there is one job
int render_picture(const RenderOptions& o, const Opened& opened, OutputFiles& files, TevStream& tev,
                   const std::shared_ptr<Ranks>& ranks, Kept* kept = nullptr, Purpose purpose = Purpose::picture) {
  const bool helps = ranks && ranks->rank() > 0;
  std::optional<Checkpoint> checkpoint;
  // All ranks continue with its numbers of photons and rays. Of the slices of time, the first continues.
  if (!o.resume.empty() && !(kept && kept->maps))
    checkpoint =
        helps ? read_key_of_checkpoint(o.resume) : read_checkpoint(o.resume, o.settings.disk, o.settings.memory_bytes);
  if (checkpoint && !helps)
    inform(fmt::format("going on from {}, which holds {} passes", o.resume, checkpoint->passes));
  const auto rehearsal = [&o](const Film& film, const Job& job) { rehearse_images(o, film, job); };
  Job job(opened.scene, opened.tracer, o.settings, checkpoint ? &*checkpoint : nullptr, {0, rehearsal}, nullptr, ranks,
          kept ? kept->maps : nullptr);
  checkpoint.reset();
  if (helps) {
    help_rank_0(job);
    return 0;
  }
  job.statistics().add_time(Phase::load, opened.load_s);
  job.statistics().add_time(Phase::build_accel, opened.build_s);
  if (!kept || !kept->maps) {
    inform(describe(o.table.settings, job.settings(), *opened.scene));
    for (const std::string& note : choice_notes(o.table.settings, job.settings())) detail("chosen: " + note);
    for (const std::string& note : effect_notes(*opened.scene, job.settings())) inform("note: " + note);
  }
  const std::exception_ptr failure = attend(job, o.report.quiet,
                                            {{1, [&] { keep_checkpoint(o, job, files, purpose == Purpose::slice); }},
                                             {2, [&] { keep_preview(o, job, files); }},
                                             {0.25, [&] { tev.show(job); }}});
  if (purpose == Purpose::slice && !failure && job.ending() == Ending::samples_done) {
    kept->maps = job.maps_for_next_slice();
    return 0;
  }
  if (purpose == Purpose::picture && kept && kept->goal && !failure && job.ending() == Ending::samples_done) {
    look_ahead(*kept->goal, job);
    if (kept->goal->next > 0) {
      kept->maps = job.maps();
      return 0;
    }
  }
  if (kept && o.sequence.reuse > 0 && !failure) kept->light = std::make_shared<const FrameLight>(frame_light(job));
  if (purpose == Purpose::light && !failure && job.ending() != Ending::cancelled) {
    kept->maps = job.maps();
    return 0;
  }
  const int status = finish_render(o, job, *opened.tracer, files, opened.start, failure);
  tev.show(job);
  if (ranks) dismiss_ranks(job, *ranks, status);
  if (kept) kept->maps = job.maps();
  return status;
}

/// The options of one frame.
RenderOptions options_of_frame(const RenderOptions& o, std::uint32_t number) {
  RenderOptions frame = o;
  for (Output& output : frame.outputs) output.path = frame_file(output.path, number);
  frame.report.statistics = frame_file(o.report.statistics, number);
  return frame;
}

/// Whether all files of a frame are there, by an earlier run.
bool is_done(const RenderOptions& frame) {
  return std::all_of(frame.outputs.begin(), frame.outputs.end(),
                     [](const Output& output) { return std::filesystem::exists(output.path); });
}

/// One of `count` shares of some frames: every `count`-th, or neighbours if frames use light of those before.
/// @param index from 0
std::vector<std::uint32_t> share_of(const std::vector<std::uint32_t>& frames, std::size_t index, std::size_t count,
                                    bool neighbours) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if ((neighbours ? i * count / frames.size() : i % count) == index) out.push_back(frames[i]);
  return out;
}

/// The key of a picture with motion blur: the key of its first slice of time, and the shutter.
RenderKey key_of_slices(const RenderOptions& o, Sequence& sequence, FrameMoment first, RenderSettings settings) {
  sequence.set_moment(first, settings);
  settings.slice = {};
  settings.photon_stream = 0;
  const Scene& scene = *sequence.scene_at(first).scene;
  RenderKey key = render_key(scene, resolve(settings, scene));
  key.push_back({"--shutter", o.sequence.shutter.empty() ? "of the file" : o.sequence.shutter});
  return key;
}

/// The first of some slices of time that a checkpoint leaves something to do of, or the last.
/// @param each settings of the slices, resolved
std::size_t slice_to_resume(const std::string& file, const std::vector<RenderSettings>& each) {
  const std::optional<Checkpoint> made = file.empty() ? std::nullopt : read_key_of_checkpoint(file);
  std::size_t i = 0;
  // The key of a checkpoint is that of the slice that it was written in.
  while (made && i + 1 < each.size() && each[i].slice_range().end - each[i].sample_range().first <= made->passes) ++i;
  return i;
}

/// Renders one frame, or one picture with motion blur: each slice of time adds its samples to the film.
/// @param o of the frame @param shown the scene that `kept` is of, and then the last one
/// @param purpose of the frame: picture or light
int render_moments(RenderOptions o, Opened& shown, Sequence& sequence, std::uint32_t number, OutputFiles& files,
                   TevStream& tev, Kept& kept, Purpose purpose = Purpose::picture) {
  const std::vector<FrameMoment> moments = sequence.moments(number);
  const RenderSettings settings = o.settings, resolved = resolve(settings, *shown.scene);
  if (moments.front().slice > 0 && !settings.part.is_all())
    o.key = key_of_slices(o, sequence, moments.front(), settings);
  std::vector<RenderSettings> each, ranges;
  std::vector<FrameMoment> rendered;
  for (const FrameMoment moment : moments) {
    RenderSettings own = settings;
    sequence.set_moment(moment, own);
    ranges.push_back(resolved);
    ranges.back().slice = own.slice;
    // A part of the render may have no samples of it.
    if (ranges.back().slice_range().count() > 0) {
      each.push_back(own);
      rendered.push_back(moment);
    } else {
      ranges.pop_back();
    }
  }
  shown.start = Clock::now();
  const std::size_t first = slice_to_resume(o.resume, ranges);
  for (std::size_t i = first; i < rendered.size(); ++i) {
    const LitScene& lit = sequence.scene_at(rendered[i]);
    if (shown.scene != lit.scene) {
      i == first ? kept.maps.reset() : kept.maps->forget_scene();
      shown.scene = lit.scene;
      shown.tracer = lit.tracer;
    }
    o.settings = each[i];
    const bool goes_on = i + 1 < rendered.size();
    const Purpose now = goes_on ? Purpose::slice : purpose;
    if (const int status = render_picture(o, shown, files, tev, nullptr, &kept, now); status != 0) return status;
    shown.load_s = shown.build_s = 0;
    // The errors of photons of several moments average.
    if (i == first && goes_on && each[i].photon_stream > 0)
      *kept.maps->photon_variance /= static_cast<double>(rendered.size());
  }
  // The mean over the moments of this frame is not the variance of the next.
  if (kept.maps && rendered.size() > 1 && each.front().photon_stream > 0) kept.maps->photon_variance.reset();
  return 0;
}

/// Renders a frame, or one picture with motion blur. If that shall end by noise or time, tries find the samples.
int render_frame(RenderOptions o, Opened& shown, Sequence& sequence, std::uint32_t number, OutputFiles& files,
                 TevStream& tev, Kept& kept) {
  RenderSettings& s = o.settings;
  const bool open_ended = s.noise_target > 0 || s.time_limit_s > 0;
  if (!open_ended || sequence.moments(number).front().slice == 0)
    return render_moments(o, shown, sequence, number, files, tev, kept);
  kept.goal =
      BlurGoal{s.noise_target, s.time_limit_s, Clock::now(), {}, 0, s.samples > 0 ? s.samples : Film::kMaxSamples};
  s.noise_target = s.time_limit_s = 0;
  s.samples = std::min(kept.goal->most, kMostSlices);
  int status = 0;
  do {
    kept.goal->samples = s.samples;
    kept.goal->begun = Clock::now();
    status = render_moments(o, shown, sequence, number, files, tev, kept);
    s.samples = kept.goal->next;
  } while (status == 0 && kept.goal->next > 0);
  kept.goal.reset();
  return status;
}

/// Light of frames by their numbers.
using FrameLights = std::map<std::uint32_t, std::shared_ptr<const FrameLight>>;

/// Finds the light that a frame uses again, and renders what is missing of it.
/// @param lights of earlier frames, and then also of those @param o of the frame
int find_earlier_light(RenderOptions& o, Opened& shown, Sequence& sequence, std::uint32_t number, OutputFiles& files,
                       TevStream& tev, Kept& kept, FrameLights& lights) {
  const std::uint32_t first = number - std::min(number, o.sequence.reuse);
  std::erase_if(lights, [&](const auto& entry) { return entry.first < first || entry.first >= number; });
  std::vector<std::shared_ptr<const FrameLight>> earlier;
  for (std::uint32_t before = first; before < number; ++before) {
    if (!sequence.shares_light(number, before)) continue;
    if (!lights.contains(before)) {
      detail(fmt::format("frame {} is rendered for its light", before));
      const int status = render_moments(o, shown, sequence, before, files, tev, kept, Purpose::light);
      if (status != 0) return status;
      lights[before] = kept.light;
    }
    earlier.push_back(lights[before]);
  }
  o.earlier = std::move(earlier);
  return 0;
}

/// Takes the memory of the light of earlier frames from that of each frame.
void reserve_light(RenderOptions& o, const Scene& scene, const std::vector<std::uint32_t>& numbers) {
  if (o.sequence.reuse == 0 || numbers.empty()) return;
  // One more for the frame itself.
  const std::uint64_t frames = std::min(o.sequence.reuse, numbers.back()) + 1;
  const std::uint64_t bytes = frames * kFrameLightBytes * resolve(o.settings, scene).bounds.pixel_count();
  if (bytes >= o.settings.memory_bytes)
    throw Error("the light of --reuse does not fit into memory", "Give fewer frames, or a larger --memory.",
                ErrorCode::memory);
  o.settings.memory_bytes -= bytes;
}

/// Renders frames, those that are there already apart. Frames in the same light share their photons and guides.
int render_frames(RenderOptions& o, const Opened& opened, Sequence& sequence, const std::vector<std::uint32_t>& numbers,
                  OutputFiles& files, TevStream& tev) {
  Kept kept;
  FrameLights lights;
  Opened shown = opened;
  reserve_light(o, *opened.scene, numbers);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    RenderOptions frame = options_of_frame(o, numbers[i]);
    if (is_done(frame)) {
      inform(fmt::format("frame {} exists, and is not rendered again", numbers[i]));
      continue;
    }
    inform(fmt::format("frame {} ({} of {})", numbers[i], i + 1, numbers.size()));
    const std::uint32_t number = numbers[i];
    int status = find_earlier_light(frame, shown, sequence, number, files, tev, kept, lights);
    if (status == 0) status = render_frame(frame, shown, sequence, number, files, tev, kept);
    if (status != 0) return status;
    if (o.sequence.reuse > 0) lights[number] = kept.light;
  }
  return 0;
}

/// The frames of the options, or the one picture with motion blur.
Sequence sequence_of(RenderOptions& o, const Opened& opened, const std::shared_ptr<SceneMotion>& motion) {
  const auto open_at = [&o, import_options = opened.import](double seconds) {
    SceneChanges changes = o.changes.changes;
    changes.moment.seconds = seconds;
    std::string camera = o.settings.camera;
    return scene_of_view(open_scene(o.scene, import_options, changes), o.lights, o.view, camera);
  };
  return Sequence(o.sequence, opened.scene, opened.tracer, o.settings, motion, open_at);
}

/// Why a picture, or the frames, cannot have motion blur; "" if they can.
std::string reason_against_blur(const RenderOptions& o, bool has_ranks) {
  const bool open_ended = o.settings.time_limit_s > 0 || o.settings.noise_target > 0;
  if (open_ended && (o.resumes || !(o.settings.part.is_all() || o.sequence.is_given())))
    return "--time and --noise find the number of samples by tries, so they do not go with --resume or --part";
  if (has_ranks && !o.sequence.is_given()) return "ranks divide the frames of a sequence, but not one picture";
  return "";
}

/// Takes motion blur out of what cannot have it. Throws CommandLineError if it was asked for.
void check_blur(const RenderOptions& o, SceneMotion* motion, bool has_ranks) {
  const std::string reason = reason_against_blur(o, has_ranks);
  if (reason.empty()) return;
  const bool asked = !o.sequence.shutter.empty() && parse_shutter(o.sequence.shutter) != Shutter();
  if (asked) throw CommandLineError("no motion blur: " + reason, "Leave out --shutter, or what it does not go with.");
  if (motion && motion->slice_count() > 0) {
    inform("note: no motion blur: " + reason);
    motion->shutter.reset();
  }
}

/// Renders a sequence: all of it, a part, or by ranks of which each renders its share.
int render_sequence(RenderOptions& o, const Opened& opened, OutputFiles& files, TevStream& tev,
                    const std::shared_ptr<SceneMotion>& motion, const std::shared_ptr<Ranks>& ranks) {
  Sequence sequence = sequence_of(o, opened, motion);
  const SampleShare part = std::exchange(o.settings.part, {});
  std::vector<std::uint32_t> numbers = sequence.numbers();
  if (!part.is_all()) numbers = share_of(numbers, part.index - 1, part.count, o.sequence.reuse > 0);
  const bool helps = ranks && ranks->rank() > 0;
  for (const std::uint32_t number : numbers)
    if (!helps) prepare_outputs(options_of_frame(o, number), files);
  std::optional<Movie> movie;
  if (o.movie && !helps) movie.emplace(*o.movie, o.names, o.sequence.frames_per_second);
  const bool any_png = std::any_of(o.outputs.begin(), o.outputs.end(),
                                   [](const Output& output) { return output.format == OutputFormat::png; });
  if (any_png && !o.picture.exposure) o.picture.exposure = sequence.exposure(o.settings);
  const std::vector<std::uint32_t> own = ranks
                                             ? share_of(numbers, static_cast<std::size_t>(ranks->rank()),
                                                        static_cast<std::size_t>(ranks->count()), o.sequence.reuse > 0)
                                             : numbers;
  int status = render_frames(o, opened, sequence, own, files, tev);
  if (helps) {
    report_end(*ranks);
    return status;
  }
  if (ranks)
    for (const std::string& failure : wait_for_ends(*ranks, [] { return caught_interrupt() != 0; })) {
      warn(failure);
      status = std::max(status, 1);
    }
  if (movie && status == 0) {
    movie->write(numbers);
    inform(fmt::format("wrote {}", movie->path()));
  }
  return status;
}

/// Loads and renders the scene. @param ranks that share the work; null: this process alone
int render_scene(RenderOptions& o, const std::shared_ptr<Ranks>& ranks) {
  const bool helps = ranks && ranks->rank() > 0;
  OutputFiles files;
  add_inputs(o, files);
  // A scene may name its picture; all else is known now.
  if (!o.outputs.empty()) {
    name_outputs(o, {});
    if (!helps && !o.sequence.is_given()) prepare_outputs(o, files);
  }
  keep_heap_small(o.settings.memory_bytes);
  TevStream tev(helps ? "" : o.tev);
  const std::shared_ptr<SceneMotion> motion = motion_of(o.sequence, o.scene, o.changes.changes.moment, o.settings);
  const Opened opened = open(o, files, helps, motion);
  check_blur(o, motion.get(), ranks != nullptr);
  if (o.outputs.empty()) {
    name_outputs(o, opened.scene->film());
    if (!helps) prepare_outputs(o, files);
  }
  if (!helps) warn_of_unused_formats(o);
  catch_interrupts();
  if (ranks)
    if (const std::string chosen = agree_on_instruction_sets(*ranks); !chosen.empty()) inform(chosen);
  if (o.sequence.is_given()) return render_sequence(o, opened, files, tev, motion, ranks);
  if (motion && motion->slice_count() > 0) {
    Sequence sequence = sequence_of(o, opened, motion);
    if (sequence.moments(0).front().slice > 0) {
      Kept kept;
      Opened shown = opened;
      return render_frame(o, shown, sequence, 0, files, tev, kept);
    }
  }
  return render_picture(o, opened, files, tev, ranks);
}

/// Renders as one rank of several. Only rank 0 prints: a rank that fails tells it why, and all ranks end with rank 0.
int render_with_others(RenderOptions& o) {
  const std::shared_ptr<Ranks> ranks = join_ranks();
  if (ranks->rank() > 0) set_log_level(LogLevel::quiet);
  int status = 1;
  std::string message;
  try {
    return render_scene(o, ranks);
  } catch (const CommandLineError& error) {
    status = 2;
    message = error.what();
  } catch (const std::exception& error) {
    message = error.what();
  }
  if (ranks->rank() > 0) {
    report_failure(*ranks, message);
    return 0;
  }
  report_error(message);
  ranks->abort(status);
  return status;
}

int run_render(RenderOptions& o) {
  o.report.apply();
  set_thread_count(o.table.settings);
  read_command_line([&] { set_simd(o.simd); });
  resolve_options(o);
  return launched_count() > 1 ? render_with_others(o) : render_scene(o, nullptr);
}

void add_picture_options(CLI::App& c, RenderOptions& o) {
  add_list(c, "Picture", "-o,--output", o.names, "FILE [the scene's, or out.exr]",
           "Image to write: .exr or .hdr (linear, W sr^-1 m^-2) or .png, or .part for 'glowworm merge'; exr:- or png:- "
           "is standard output; several -o may be given");
  add_table_options(c, "Picture", Command::render, o.table);
  add_text(c, "Picture", "--view", o.view, "X,Y,Z,X,Y,Z,X,Y,Z",
           "Move the camera: nine numbers for eye, target and up; the lens does not change");
  add_light_option(
      c, "Picture", o.lights,
      "Change a light: off, scale=S, move=X:Y:Z (m), turn=X:Y:Z (axis times radians); or add a luminaire of a "
      "photometric file (IES LM-63, EULUMDAT) at X,Y,Z that aims along DX,DY,DZ [0,-1,0], turned by TURN degrees. It "
      "hangs with C0 along x, and tilts to its aim by the shortest way; types A and B stand level. ,scale=F and "
      ",maintenance=F behind that are factors, ,lamps=NAME or =NUMBER chooses lamps, ,opening=off makes a point");
  add_text(c, "Picture", "--tev", o.tev, "HOST:PORT", "Show the unfinished image in a running tev");
  add_picture_options(c, "Picture", o.picture);
  add_sequence_options(c, "Sequence", o.sequence);
}

void add_effort_options(CLI::App& c, RenderOptions& o) {
  add_table_options(c, "Effort", Command::render, o.table);
  c.add_option("--resume", o.resume,
               "Keep a checkpoint in a file, and continue from it if it exists; give it as the last option, or as "
               "--resume=FILE")
      ->expected(0, 1)
      ->option_text("[FILE] [OUTPUT.checkpoint]")
      ->group("Effort");
  c.add_flag("--preview", o.preview, "Write the unfinished image every two seconds, or less often if writing is slow")
      ->group("Effort");
}

/// Whether an option was given. CLI::App::count() would end the program if memory runs out.
bool is_given(const CLI::App& c, std::string_view name) {
  for (const CLI::Option* option : c.get_options())
    for (const std::string& own : option->get_lnames())
      if (name.substr(2) == own) return option->count() > 0;
  return false;
}

/// Warns of options that have no effect with others.
void warn_of_ignored(const TableOptions& table) {
  for (const Option* option : table.given)
    if (!option->has_effect(table.settings))
      warn(fmt::format("{} has no effect with {}", option->name, option->overruled_by(table.settings)));
}

constexpr const char* kRenderFooter = R"(
Nothing has to be set: 'auto' values are chosen for the scene, and --stats shows them.
Lengths are metres, radiance is W sr^-1 m^-2 in linear RGB (Rec. 709).
Ctrl-C finishes the current task, writes the image so far and exits with status 130;
a second one ends at once. Status 1 is an error, 2 a wrong command line.

Examples:
  glowworm render builtin:cornell -o cornell.png
  glowworm render room.glb --size 1280x720 --camera desk --time 5m -o room.exr -o room.png
  glowworm render builtin:atrium --samples 4 --gather 64 --aov direct,indirect --stats atrium.json
  glowworm render builtin:ajar --integrator path --samples 1k -o reference.exr)";

}  // namespace

void add_render_command(CLI::App& program, const std::string& command_line, int& exit_status) {
  auto options = std::make_shared<RenderOptions>();
  options->command_line = command_line;
  CLI::App* c = program.add_subcommand("render", "Renders a scene to an image.");
  add_scene_argument(*c, options->scene);
  add_picture_options(*c, *options);
  add_scene_options(*c, options->changes);
  add_table_options(*c, "Method", Command::render, options->table);
  add_effort_options(*c, *options);
  add_table_options(*c, "Machine", Command::render, options->table);
  add_simd_option(*c, "Machine", options->simd);
  add_report_options(*c, true, options->report);
  c->footer(kRenderFooter);
  c->callback([c, options, &exit_status] {
    options->resumes = is_given(*c, "--resume");
    warn_of_ignored(options->table);
    exit_status = run_render(*options);
  });
}

}  // namespace glowworm
