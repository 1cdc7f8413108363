#include "apps/render_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/commands.h"
#include "apps/interrupt.h"
#include "control/job_report.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"
#include "core/text.h"
#include "film/checkpoint.h"
#include "film/output.h"
#include "film/part.h"
#include "maps/photon_noise.h"

namespace glowworm {

namespace {

using Clock = std::chrono::steady_clock;

bool has_samples(const Film& film) {
  for (std::size_t i = 0; i < film.pixel_count(); ++i)
    if (film.sample_count(i) > 0) return true;
  return false;
}

/// A film of the job as its picture.
Image image_of(const RenderOptions& o, const Film& film, const Job& job) {
  PictureInfo info = picture_info(job);
  if (!o.earlier.empty()) info.earlier = std::make_shared<const EarlierFrames>(frame_view(film, job), o.earlier);
  return make_image(film, info);
}

/// Writes the image to every -o. Returns its estimated relative error, or "" if unknown.
/// @param said print messages
std::string write_images(const RenderOptions& o, const Job& job, OutputFiles& files, bool said) {
  const DiskMemory::Scope scope(job.disk(), DiskMemory::kLeastOfChannels);
  const auto with_film = [&](const auto& use) { return job.done() ? use(job.film()) : use(job.snapshot()); };
  std::optional<Image> image;
  for (const Output& output : o.outputs) {
    const std::string& path = output.path;
    // Output on standard output cannot be replaced later.
    if (path == kStandardOutput && !said) continue;
    if (output.format == OutputFormat::part && !said) continue;
    std::string how;
    const bool written = files.write(path, [&] {
      if (output.format == OutputFormat::part) {
        Part part = part_of(job);
        if (o.key) part.key = key_of_whole(*o.key);
        return with_film([&](const Film& film) { write_part(path, part, film); });
      }
      if (!image) {
        image = with_film([&](const Film& film) { return image_of(o, film, job); });
        image->metadata["comments"] = o.command_line;
      }
      how = write_picture(output, *image, o.picture);
    });
    if (written && said && path != kStandardOutput) inform(fmt::format("wrote {}{}", path, how));
  }
  return image && image->metadata.contains(kRelativeError) ? image->metadata.at(kRelativeError) : "";
}

/// Does what write_images() does, for a part of the film, and leaves no files. What fails here fails again, and is

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

}  // namespace

double seconds_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

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

void add_inputs(const RenderOptions& o, OutputFiles& files) {
  files.add_input("the scene", o.scene);
  files.add_input("--environment", o.changes.changes.environment_file);
  files.add_input("--script", o.sequence.script);
  files.add_input("--ocio", o.picture.color.request.config);
}

void prepare_outputs(const RenderOptions& o, OutputFiles& files) {
  for (const Output& output : o.outputs) files.add("-o", output.path);
  files.add("--stats", o.report.statistics);
  files.add("--resume", o.resume);
  // Probing or reading a pipe would block forever.
  if (!o.resume.empty() && std::filesystem::exists(o.resume)) check_input_file(o.resume);
  bool any = false;
  for (const Output& output : o.outputs) any = files.probe(output.path) || any;
  if (!any) files.throw_if_any_failed();
  for (const std::string& path : {o.report.statistics, o.resume})
    if (!path.empty()) files.probe(path);
}

void rehearse_images(const RenderOptions& o, const Film& film, const Job& job) try {
  constexpr const char* kNowhere = "/dev/null";
  std::optional<Image> image;
  for (const Output& output : o.outputs) {
    if (output.format == OutputFormat::part) {
      write_part(kNowhere, part_of(job), film);
      continue;
    }
    if (!image) image = image_of(o, film, job);
    write_picture({kNowhere, output.format}, *image, o.picture);
  }
} catch (const Error&) {
}

void keep_checkpoint(const RenderOptions& o, const Job& job, OutputFiles& files, bool goes_on) {
  if (o.resume.empty()) return;
  const Checkpoint made = job.checkpoint();
  // After the last sample of a slice the next one continues, and its key is another.
  const RenderSettings s = job.settings();
  if (goes_on && made.passes >= s.slice_range().end - s.sample_range().first) return;
  files.write(o.resume, [&] { write_checkpoint(o.resume, made); });
}

void keep_preview(const RenderOptions& o, const Job& job, OutputFiles& files) {
  if (o.preview && job.tasks() > 0) write_images(o, job, files, false);
}

int finish_render(const RenderOptions& o, Job& job, const Tracer& tracer, OutputFiles& files,
                  std::chrono::steady_clock::time_point start, const std::exception_ptr& failure) {
  const bool any = has_samples(job.film());
  // A frame whose files exist is not rendered again, so an unfinished one writes none.
  if (o.sequence.is_given() && job.ending() == Ending::cancelled) return end_without_picture(o);
  if (o.sequence.is_given() && failure) std::rethrow_exception(failure);
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

int end_without_picture(const RenderOptions& o) {
  if (!o.sequence.is_given()) warn_of_ending(Ending::cancelled, false);
  return kExitSignalled + caught_interrupt();
}

void warn_of_unused_formats(const RenderOptions& o) {
  const bool beauty_alone = std::all_of(o.outputs.begin(), o.outputs.end(), [](const Output& output) {
    return output.format == OutputFormat::png || output.format == OutputFormat::hdr;
  });
  const bool no_layers = beauty_alone && o.tev.empty();
  if (no_layers && !o.table.settings.aovs.empty()) warn("--aov has no effect: no -o is an EXR file");
  if (no_layers && o.settings.light_groups) warn("--light-groups has no effect: no -o is an EXR file");
  warn_of_unused_formats(o.picture, o.outputs);
}

}  // namespace glowworm
