// `glowworm view --out`: a session without a window.
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <optional>
#include <set>

#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/output_files.h"
#include "apps/view_options.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/text.h"

namespace glowworm {

namespace {

/// @param exposure stops; if empty, it is chosen from the frame and kept
void write_frame(const ViewOptions& o, const ViewFrame& frame, const std::string& path,
                 std::optional<float>& exposure) {
  if (lower_ending(path) == ".exr") {
    write_exr(path, frame_image(frame));
    return;
  }
  // False colours are shown unchanged.
  const bool tone = frame.is_light && o.tone == "filmic";
  if (frame.is_light && !exposure) exposure = automatic_exposure(frame.image.light);
  if (o.color.view && frame.is_light) return write_png(path, frame_image(frame), *o.color.view, *exposure);
  write_png(path, frame_image(frame), tone ? ToneCurve::filmic : ToneCurve::srgb, frame.is_light ? *exposure : 0);
}

std::string table_head() {
  std::string text = "frame,seconds,width,height,samples,gather,photons,reuse_s,filter_s";
  for (int i = 0; i < static_cast<int>(Phase::count_); ++i) text += fmt::format(",{}_s", name(static_cast<Phase>(i)));
  for (int i = 0; i < static_cast<int>(Counter::count_); ++i) text += fmt::format(",{}", name(static_cast<Counter>(i)));
  return text + "\n";
}

std::string table_row(std::uint32_t number, const ViewFrame& frame) {
  std::string text = fmt::format("{},{:.6f},{},{},{},{},{},{:.6f},{:.6f}", number, frame.cost.seconds,
                                 frame.image.width, frame.image.height, frame.samples, frame.effort.gather,
                                 frame.photons, frame.cost.reuse_seconds, frame.cost.filter_seconds);
  for (const double seconds : frame.cost.phase_seconds) text += fmt::format(",{:.6f}", seconds);
  for (const std::uint64_t count : frame.cost.counts) text += fmt::format(",{}", count);
  return text + "\n";
}

/// The content of frames.csv, and the number of frames written.
struct FrameTable {
  std::string text = table_head();
  std::uint32_t written = 0;
};

/// A session of a scene, with its state.
struct Stage {
  std::unique_ptr<Session> session;
  ViewState state;

  Stage(const ViewOptions& o, const Script& script, const std::string& scene, OutputFiles& files) {
    const SessionSettings settings = session_settings(o, false);
    SceneMoments moments;
    const std::shared_ptr<const Scene> opened = open_view_scene(o, scene, settings.memory_bytes, moments, &files);
    session = std::make_unique<Session>(opened, settings, moments);
    state = first_state(o, script, *opened, session->initial_state());
  }
};

/// Replaces the scene. An interrupt leaves the stage unchanged.
void change_scene(Stage& stage, const ViewOptions& o, const Script& script, const std::string& scene,
                  OutputFiles& files) try {
  const CancellationScope scope(signal_interrupt());
  stage = Stage(o, script, scene, files);
} catch (const Cancelled&) {
}

bool is_frame_name(const std::string& name, const std::string& format) {
  const std::size_t digits = std::min(name.find_first_not_of("0123456789"), name.size());
  return digits >= 5 && name.substr(digits) == "." + format;
}

/// Throws CommandLineError if a frame would overwrite another file of the session.
void check_frames(const ViewOptions& o, const OutputFiles& files) {
  std::error_code not_there_yet;
  for (const auto& entry : std::filesystem::directory_iterator(o.out, not_there_yet))
    if (is_frame_name(entry.path().filename(), o.format)) files.check("the frame", entry.path());
}

/// Throws CommandLineError if two outputs of the session, or an output and an input, are the same file.
void prepare_outputs(const ViewOptions& o, const Script& script, OutputFiles& files) {
  const std::filesystem::path folder = o.out;
  files.add_input("the scene", o.scene);
  files.add_input("--environment", o.changes.changes.environment_file);
  files.add_input("--script", o.script);
  files.add_input("--ocio", o.color.request.config);
  for (const ScriptMove& move : script.moves)
    if (move.drop) files.add_input("the scene of a \"drop\"", *move.drop);
  files.add("frames.csv of --out,", folder / "frames.csv");
  std::set<std::string> screenshots;
  for (const ScriptMove& move : script.moves)
    if (move.screenshot && screenshots.insert(*move.screenshot).second) {
      const std::filesystem::path name = std::filesystem::path(*move.screenshot).lexically_normal();
      files.add("the \"screenshot\"", folder / name);
      if (is_frame_name(name, o.format)) files.check("the frame", folder / name);
    }
  check_frames(o, files);
}

/// Plays the script, and adds a row to the table for each frame.
void play_frames(const ViewOptions& o, const Script& script, Stage& stage, OutputFiles& files, FrameTable& table) {
  const std::uint32_t frames = o.frames > 0 ? o.frames : script_length(script);
  ViewFrame frame;
  double clock = 0;
  std::optional<float> exposure = o.exposure;
  for (std::uint32_t i = 0; i < frames && !caught_interrupt(); ++i) {
    for (const ScriptMove& move : script.moves)
      if (move.drop && move.from == i) {
        change_scene(stage, o, script, *move.drop, files);
        exposure = o.exposure;
      }
    if (caught_interrupt()) break;
    play(script, i, stage.session->scene(), stage.session->rig(), i > 0 ? &frame : nullptr, stage.state);
    frame = stage.session->next_frame(stage.state, clock);
    // Frames with a deadline use the real clock.
    clock += o.adapt ? frame.cost.seconds : 1 / script.frames_per_second;
    const std::string path = std::filesystem::path(o.out) / fmt::format("{:05}.{}", i, o.format);
    if (files.write(path, [&] { write_frame(o, frame, path, exposure); })) ++table.written;
    for (const ScriptMove& move : script.moves)
      if (move.screenshot && move.from == i) {
        const std::string shot = std::filesystem::path(o.out) / *move.screenshot;
        files.write(shot, [&] { write_frame(o, frame, shot, exposure); });
      }
    table.text += table_row(i, frame);
  }
}

}  // namespace

int run_headless_view(const ViewOptions& o, const Script& script) {
  OutputFiles files;
  prepare_outputs(o, script, files);
  Stage stage(o, script, o.scene, files);
  check_frames(o, files);
  tell_notes(stage.session->scene(), o.scene);
  std::error_code error;
  std::filesystem::create_directories(o.out, error);
  if (error)
    throw Error(fmt::format("the folder '{}' cannot be created: {}", o.out, error.message()),
                "Give --out a writable folder.");
  catch_interrupts();
  FrameTable table;
  std::exception_ptr failure;
  try {
    play_frames(o, script, stage, files, table);
  } catch (...) {
    failure = std::current_exception();
  }
  const std::string path = std::filesystem::path(o.out) / "frames.csv";
  const bool listed = files.write(path, [&] { write_file(path, table.text); });
  inform(fmt::format("wrote {} frames{} to {}", table.written, listed ? " and frames.csv" : "", o.out));
  if (failure) std::rethrow_exception(failure);
  files.throw_if_any_failed();
  return caught_interrupt() ? kExitSignalled + caught_interrupt() : 0;
}

}  // namespace glowworm
