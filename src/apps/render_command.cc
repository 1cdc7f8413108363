#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/attend.h"
#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "apps/output_files.h"
#include "apps/picture_output.h"
#include "apps/table_options.h"
#include "apps/tev_stream.h"
#include "control/job.h"
#include "control/job_report.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "core/small_arrays.h"
#include "core/text.h"
#include "film/checkpoint.h"
#include "film/output.h"
#include "film/part.h"
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

struct RenderOptions {
  std::string scene, command_line;
  std::vector<std::string> names;  ///< values of -o
  std::vector<Output> outputs;
  std::string simd = "auto", resume, view, tev;
  std::vector<std::string> lights;
  PictureOptions picture;
  bool preview = false, resumes = false;
  ReportOptions report;
  TableOptions table;
  SceneOptions changes;
  RenderSettings settings;  ///< settings of the table, with the memory available
};

double seconds_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

/// Without -o, the image gets the name that the scene gives it, or "out.exr". A part is named by its numbers.
void name_outputs(RenderOptions& o, const FilmRequest& film) {
  const SampleShare& part = o.settings.part;
  if (o.outputs.empty() && !part.is_all())
    o.outputs.push_back(output_of(fmt::format("{}-of-{}.part", part.index, part.count)));
  if (o.outputs.empty()) {
    std::string name = film.file.empty() ? "out.exr" : film.file;
    if (const std::string ending = lower_ending(name); ending != ".exr" && ending != ".png") {
      name = std::filesystem::path(name).replace_extension(".exr");
      inform(fmt::format("note: the image of '{}' is written as {}", film.file, name));
    }
    o.outputs.push_back(output_of(name));
  }
  if (o.resumes && o.resume.empty()) o.resume = o.outputs.front().path + ".checkpoint";
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
  for (const std::string& name : o.names) {
    o.outputs.push_back(output_of(name));
    if (o.outputs.back().format == OutputFormat::part) check_part_output(name, s);
  }
}

/// Checks before the render that all files differ and can be written.
void prepare_outputs(const RenderOptions& o, OutputFiles& files) {
  files.add_input("the scene", o.scene);
  if (const std::string& sky = o.changes.changes.environment_file; !sky.empty()) files.add_input("--environment", sky);
  for (const Output& output : o.outputs) files.add("-o", output.path);
  if (!o.report.statistics.empty()) files.add("--stats", o.report.statistics);
  if (!o.resume.empty()) files.add("--resume", o.resume);
  // Probing or reading a pipe would block forever.
  if (!o.resume.empty() && std::filesystem::exists(o.resume)) check_input_file(o.resume);
  bool any = false;
  for (const Output& output : o.outputs) any = files.probe(output.path) || any;
  if (!any) files.throw_if_any_failed();
  for (const std::string& path : {o.report.statistics, o.resume})
    if (!path.empty()) files.probe(path);
}

bool has_samples(const Film& film) {
  for (std::size_t i = 0; i < film.pixel_count(); ++i)
    if (film.sample_count(i) > 0) return true;
  return false;
}

/// Writes the image to every -o. Returns its estimated relative error, or "" if unknown.
/// @param said print messages
std::string write_images(const RenderOptions& o, const Job& job, OutputFiles& files, bool said) {
  const DiskMemory::Scope scope(job.disk());
  const SmallArraysOnDisk small;
  const auto with_film = [&](const auto& use) { return job.done() ? use(job.film()) : use(job.snapshot()); };
  std::optional<Image> image;
  for (const Output& output : o.outputs) {
    const std::string& path = output.path;
    // Output on standard output cannot be replaced later.
    if (path == kStandardOutput && !said) continue;
    if (output.format == OutputFormat::part && !said) continue;
    std::string how;
    const bool written = files.write(path, [&] {
      if (output.format == OutputFormat::part)
        return with_film([&](const Film& film) { write_part(path, part_of(job), film); });
      if (!image) {
        image = with_film([&](const Film& film) { return make_image(film, job); });
        image->metadata["comments"] = o.command_line;
      }
      how = write_picture(output, *image, o.picture);
    });
    if (written && said && path != kStandardOutput) inform(fmt::format("wrote {}{}", path, how));
  }
  return image && image->metadata.contains(kRelativeError) ? image->metadata.at(kRelativeError) : "";
}

/// Does what write_images() does, for a part of the film, and leaves no files. What fails here fails again, and is
/// reported, when the files are written.
void rehearse_images(const RenderOptions& o, const Film& film, const Job& job) try {
  constexpr const char* kNowhere = "/dev/null";
  std::optional<Image> image;
  for (const Output& output : o.outputs) {
    if (output.format == OutputFormat::part) {
      write_part(kNowhere, part_of(job), film);
      continue;
    }
    if (!image) image = make_image(film, job);
    write_picture({kNowhere, output.format}, *image, o.picture);
  }
} catch (const Error&) {
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

/// The seconds of the whole that no phase has, such as those before and after a render.
double seconds_beside_phases(const Statistics& statistics) {
  double seconds = statistics.seconds(Phase::total);
  for (int i = 0; i < static_cast<int>(Phase::count_); ++i)
    if (static_cast<Phase>(i) != Phase::total) seconds -= statistics.seconds(static_cast<Phase>(i));
  return seconds;
}

/// Prints the time of each phase, for -v.
void describe_times(const Statistics& statistics) {
  for (int i = 0; i < static_cast<int>(Phase::count_); ++i) {
    const auto phase = static_cast<Phase>(i);
    if (statistics.seconds(phase) > 0) detail(fmt::format("{:>9.3f} s  {}", statistics.seconds(phase), name(phase)));
  }
}

/// Prints the fate of each light's photons, for -v.
void describe_photons(const Job& job) {
  for (const LightPhotons& light : job.light_photons())
    detail(fmt::format("photons of {} ({} sources): {} emitted, {} stored, {} used, {} wasted", light.name,
                       light.sources, light.emitted, light.stored, light.used, light.wasted()));
}

/// Writes a checkpoint to the file of --resume.
void keep_checkpoint(const RenderOptions& o, const Job& job, OutputFiles& files) {
  if (!o.resume.empty()) files.write(o.resume, [&] { write_checkpoint(o.resume, job.checkpoint()); });
}

/// Writes the unfinished image, if there is one.
void keep_preview(const RenderOptions& o, const Job& job, OutputFiles& files) {
  if (o.preview && job.tasks() > 0) write_images(o, job, files, false);
}

/// Writes all files. @param any whether there is any image
void write_outputs(const RenderOptions& o, Job& job, const Tracer& tracer, OutputFiles& files, Clock::time_point start,
                   bool any) {
  const Clock::time_point rendered = Clock::now();
  Statistics& statistics = job.statistics();
  const std::string error = any ? write_images(o, job, files, true) : "";
  keep_checkpoint(o, job, files);
  statistics.add_time(Phase::output, seconds_between(rendered, Clock::now()));
  // The job has counted its own time; the total covers the whole run.
  statistics.add_time(Phase::total, seconds_between(start, Clock::now()) - statistics.seconds(Phase::total));
  statistics.add_time(Phase::other, std::max(seconds_beside_phases(statistics), 0.0));
  describe_times(statistics);
  describe_photons(job);
  if (!o.report.statistics.empty())
    files.write(o.report.statistics, [&] { write_file(o.report.statistics, statistics_of(job, tracer).json + "\n"); });
  if (job.samples_not_finite() > 0)
    warn(fmt::format("{} camera samples are black, because their light was beyond what pictures hold",
                     job.samples_not_finite()));
  const RenderSettings settings = job.settings();
  const double target = settings.noise_target, photons = std::sqrt(job.photon_variance());
  if (target > 0 && std::hypot(noise_left_to_samples(target, job.photon_variance()), photons) > 1.1 * target)
    warn(
        fmt::format("the photons, which all samples share, add a relative error of {:.2g}, too much for --noise: give "
                    "--progressive, or --photons and --nearest above {} and {}",
                    photons, settings.photons, settings.nearest));
  inform(fmt::format("{:.4g} samples a pixel in {:.2f} s{}", job.mean_samples(), statistics.seconds(Phase::total),
                     error.empty() ? "" : fmt::format(", estimated relative error {}", error)));
}

/// Warns if the render ended early, and says what the files hold. @param any whether there is any image
void warn_of_ending(Ending ending, bool any) {
  if (ending == Ending::cancelled)
    warn(any ? "interrupted: the files hold the image so far"
             : "interrupted before any part of the image was finished: no image was written");
  else if (ending == Ending::failed)
    warn("the render failed: the files hold the image so far");
  else if (!any)
    warn("the time limit ended the render before any part of the image was finished: no image was written");
}

/// Writes the results, then throws the error, if any, or returns the exit status. @param failure of the render, or null
int finish(const RenderOptions& o, Job& job, const Tracer& tracer, OutputFiles& files, Clock::time_point start,
           const std::exception_ptr& failure) {
  const bool any = has_samples(job.film());
  if (failure && !any) std::rethrow_exception(failure);
  write_outputs(o, job, tracer, files, start, any);
  const RenderSettings settings = job.settings();
  if (job.is_fitted())
    inform(fmt::format(
        "note: --time left room for {} photons{}", settings.photons,
        settings.integrator == Integrator::gather ? fmt::format(" and {} gather rays a sample", settings.gather) : ""));
  if (job.has_more_photons())
    inform(fmt::format("note: --noise took {} photons, because the noise of fewer is too large", settings.photons));
  if (job.ending() == Ending::time_up && settings.noise_target > 0)
    inform("note: --time ended the render before the error of --noise was reached");
  warn_of_ending(job.ending(), any);
  if (failure) std::rethrow_exception(failure);
  files.throw_if_any_failed();
  if (job.ending() == Ending::cancelled) return kExitSignalled + caught_interrupt();
  return any ? 0 : 1;
}

/// Warns of options that have no effect on the output formats.
void warn_of_unused_formats(const RenderOptions& o) {
  const bool all_png = std::all_of(o.outputs.begin(), o.outputs.end(),
                                   [](const Output& output) { return output.format == OutputFormat::png; });
  const bool no_layers = all_png && o.tev.empty();
  if (no_layers && !o.table.settings.aovs.empty()) warn("--aov has no effect: no -o is an EXR file");
  if (no_layers && o.settings.light_groups) warn("--light-groups has no effect: no -o is an EXR file");
  warn_of_unused_formats(o.picture, o.outputs);
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

/// Loads and renders the scene. @param ranks that share the work; null: this process alone
int render_scene(RenderOptions& o, const std::shared_ptr<Ranks>& ranks) {
  const bool helps = ranks && ranks->rank() > 0;
  OutputFiles files;
  // A scene may name its picture; all else is known now.
  if (!o.outputs.empty()) {
    name_outputs(o, {});
    if (!helps) prepare_outputs(o, files);
  }
  keep_heap_small(o.settings.memory_bytes);
  const Clock::time_point start = Clock::now();
  ImportOptions import_options;
  import_options.budget = loading_budget(o.settings.memory_bytes);
  TevStream tev(helps ? "" : o.tev);
  std::shared_ptr<const Scene> scene = open_scene(o.scene, import_options, o.changes.changes, &files);
  read_command_line([&] {
    scene = scene_of_view(scene, o.lights, o.view, o.settings.camera);
    const PixelBounds bounds = resolve(o.settings, *scene).bounds;
    if (!o.settings.bounds.empty() && bounds != o.settings.bounds)
      warn(fmt::format("--pixel-bounds reaches beyond the picture: only {},{},{},{} is rendered", bounds.x0, bounds.y0,
                       bounds.x1, bounds.y1));
  });
  const Clock::time_point loaded = Clock::now();
  if (!helps) tell_notes(*scene, o.scene);
  if (o.outputs.empty()) {
    name_outputs(o, scene->film());
    if (!helps) prepare_outputs(o, files);
  }
  if (!helps) warn_of_unused_formats(o);
  if (ranks)
    if (const std::string chosen = agree_on_instruction_sets(*ranks); !chosen.empty()) inform(chosen);
  const auto tracer = std::make_shared<const Tracer>(*scene);
  const Clock::time_point built = Clock::now();
  catch_interrupts();
  std::optional<Checkpoint> checkpoint;
  // All ranks continue with its numbers of photons and rays.
  if (!o.resume.empty())
    checkpoint =
        helps ? read_key_of_checkpoint(o.resume) : read_checkpoint(o.resume, o.settings.disk, o.settings.memory_bytes);
  if (checkpoint && !helps)
    inform(fmt::format("going on from {}, which holds {} passes", o.resume, checkpoint->passes));
  const auto rehearsal = [&o](const Film& film, const Job& job) { rehearse_images(o, film, job); };
  Job job(scene, tracer, o.settings, checkpoint ? &*checkpoint : nullptr, {0, rehearsal}, nullptr, ranks);
  checkpoint.reset();
  if (helps) {
    help_rank_0(job);
    return 0;
  }
  job.statistics().add_time(Phase::load, seconds_between(start, loaded));
  job.statistics().add_time(Phase::build_accel, seconds_between(loaded, built));
  inform(describe(o.table.settings, job.settings(), *scene));
  for (const std::string& note : choice_notes(o.table.settings, job.settings())) detail("chosen: " + note);
  for (const std::string& note : effect_notes(*scene, job.settings())) inform("note: " + note);
  const std::exception_ptr failure = attend(job, o.report.quiet,
                                            {{1, [&] { keep_checkpoint(o, job, files); }},
                                             {2, [&] { keep_preview(o, job, files); }},
                                             {0.25, [&] { tev.show(job); }}});
  const int status = finish(o, job, *tracer, files, start, failure);
  tev.show(job);
  if (ranks) dismiss_ranks(job, *ranks, status);
  return status;
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
  c.add_option("-o,--output", o.names,
               "Image to write: .exr (linear, W sr^-1 m^-2) or .png, or .part for 'glowworm merge'; exr:- or png:- is "
               "standard output; several -o may be given")
      ->allow_extra_args(false)
      ->option_text("FILE [the scene's, or out.exr]")
      ->group("Picture");
  add_table_options(c, "Picture", Command::render, o.table);
  add_text(c, "Picture", "--view", o.view, "X,Y,Z,X,Y,Z,X,Y,Z",
           "Move the camera: nine numbers for eye, target and up; the lens does not change");
  c.add_option(
       "--light", o.lights,
       "Change a light: off, scale=S, move=X:Y:Z (m), turn=X:Y:Z (axis times radians); or add a luminaire of a "
       "photometric file (IES LM-63, EULUMDAT) at X,Y,Z that aims along DX,DY,DZ [0,-1,0], turned by TURN degrees")
      ->allow_extra_args(false)
      ->option_text("NAME,CHANGE,...|FILE@X,Y,Z[,DX,DY,DZ[,TURN]]")
      ->group("Picture");
  add_text(c, "Picture", "--tev", o.tev, "HOST:PORT", "Show the unfinished image in a running tev");
  add_picture_options(c, "Picture", o.picture);
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
