// The options of `glowworm render`, and the files that it writes.
#pragma once
#include <chrono>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "apps/open_scene.h"
#include "apps/output_files.h"
#include "apps/picture_output.h"
#include "apps/sequence.h"
#include "apps/table_options.h"
#include "control/job.h"
#include "film/earlier_frames.h"

namespace glowworm {

struct RenderOptions {
  std::string scene, command_line;
  std::vector<std::string> names;  ///< values of -o
  std::vector<Output> outputs;
  std::string simd = "auto", resume, view, tev;
  std::vector<std::string> lights;
  PictureOptions picture;
  SequenceOptions sequence;
  std::optional<std::string> movie;
  bool preview = false, resumes = false;
  ReportOptions report;
  TableOptions table;
  SceneOptions changes;
  RenderSettings settings;       ///< settings of the table, with the memory available
  FrameLights earlier;           ///< frames whose light a frame uses again
  std::size_t tested = 0;        ///< number of these, the last ones, whose light counts in the test of --noise
  std::optional<RenderKey> key;  ///< of a picture with motion blur, which several jobs with keys of their own render
};

/// Seconds from one time to another.
double seconds_between(std::chrono::steady_clock::time_point start, std::chrono::steady_clock::time_point end);

/// Without -o, the image gets the name that the scene gives it, or "out.exr". A part is named by its numbers.
void name_outputs(RenderOptions& o, const FilmRequest& film);

/// Notes the files that the render reads.
void add_inputs(const RenderOptions& o, OutputFiles& files);

/// Checks before the render that all files differ and can be written.
void prepare_outputs(const RenderOptions& o, OutputFiles& files);

/// Does what writing the images does, for a part of the film, and leaves no files. What fails here fails again, and is
/// reported, when the files are written.
void rehearse_images(const RenderOptions& o, const Film& film, const Job& job);

/// Writes a checkpoint to the file of --resume.
void keep_checkpoint(const RenderOptions& o, const Job& job, OutputFiles& files, bool goes_on = false);

/// Writes the unfinished image, if there is one.
void keep_preview(const RenderOptions& o, const Job& job, OutputFiles& files);

/// Writes the results, then throws the error, if any, or returns the exit status. Of an unfinished frame of a sequence
/// writes nothing. @param failure of the render, or null
int finish_render(const RenderOptions& o, Job& job, const Tracer& tracer, OutputFiles& files,
                  std::chrono::steady_clock::time_point start, const std::exception_ptr& failure);

/// Warns that Ctrl-C came before any sample of the picture; of a frame of a sequence says nothing. Returns the exit
/// status.
int end_without_picture(const RenderOptions& o);

/// Warns of options that have no effect on the output formats.
void warn_of_unused_formats(const RenderOptions& o);

}  // namespace glowworm
