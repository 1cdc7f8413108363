#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <memory>
#include <utility>

#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "apps/output_files.h"
#include "apps/picture_output.h"
#include "apps/render_frames.h"
#include "apps/render_outputs.h"
#include "apps/render_picture.h"
#include "apps/sequence.h"
#include "apps/table_options.h"
#include "apps/tev_stream.h"
#include "core/error.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "core/text.h"
#include "kernels/simd.h"
#include "session/command_text.h"
#include "settings/settings.h"
#include "share/ranks.h"

namespace glowworm {

namespace {

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
  if (o.sequence.is_given()) o.sequence.part = std::exchange(s.part, {});
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
  const bool asks_for_blur = !o.sequence.shutter.empty() && parse_shutter(o.sequence.shutter) != Shutter();
  if (asks_for_blur && !o.sequence.is_given()) check_blur(o, ranks != nullptr);
  // The scene's Tracer keeps the instruction set that it is made with.
  if (ranks)
    if (const std::string chosen = agree_on_instruction_sets(*ranks); !chosen.empty()) inform(chosen);
  const Opened opened = open_render(o, files, helps, motion);
  if (o.outputs.empty()) {
    name_outputs(o, opened.scene->film());
    if (!helps) prepare_outputs(o, files);
  }
  if (!helps) warn_of_unused_formats(o);
  catch_interrupts();
  if (o.sequence.is_given()) return render_sequence(o, opened, files, tev, motion, ranks);
  if (motion && motion->slice_count() > 0) {
    Sequence sequence = sequence_of(o, opened, motion);
    if (sequence.moments(0).front().slice > 0) return render_blurred(o, opened, sequence, files, tev, ranks);
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
