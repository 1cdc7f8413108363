// `glowworm view --out`: a session without a window.
#include <fmt/format.h>

#include <filesystem>

#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "apps/view_options.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

void write_frame(const ViewOptions& o, const ViewFrame& frame, const std::string& path) {
  if (std::filesystem::path(path).extension() == ".exr") {
    write_exr(path, frame_image(frame));
    return;
  }
  // False colours are for display as they are.
  const bool tone = frame.is_light && o.tone == "filmic";
  write_png(path, frame_image(frame), tone ? ToneCurve::filmic : ToneCurve::srgb, frame.is_light ? o.exposure : 0);
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

/// A session of a scene and the state it is in.
struct Stage {
  std::unique_ptr<Session> session;
  ViewState state;

  Stage(const ViewOptions& o, const Script& script, const std::string& scene)
      : session(std::make_unique<Session>(open_scene(scene, {}), session_settings(o, false))),
        state(first_state(o, script, session->scene(), session->initial_state())) {}
};

/// Puts another scene in the place of this one; an interrupt leaves it as it is.
void change_scene(Stage& stage, const ViewOptions& o, const Script& script, const std::string& scene) try {
  const CancellationScope scope(interrupt_flag());
  stage = Stage(o, script, scene);
} catch (const Cancelled&) {
}

}  // namespace

int run_headless_view(const ViewOptions& o, const Script& script) {
  Stage stage(o, script, o.scene);
  for (const std::string& note : stage.session->scene().notes()) inform(fmt::format("note: {}: {}", o.scene, note));
  std::error_code error;
  std::filesystem::create_directories(o.out, error);
  if (error)
    throw Error(fmt::format("the folder '{}' cannot be made: {}", o.out, error.message()),
                "Give --out a folder that may be written to.");
  catch_interrupts();
  const std::uint32_t frames = script_length(script, o.frames);
  std::string table = table_head();
  ViewFrame frame;
  double clock = 0;
  for (std::uint32_t i = 0; i < frames && !caught_interrupt(); ++i) {
    for (const ScriptMove& move : script.moves)
      if (move.drop && move.from == i) change_scene(stage, o, script, *move.drop);
    if (caught_interrupt()) break;
    play(script, i, stage.session->scene(), stage.session->rig(), i > 0 ? &frame : nullptr, stage.state);
    frame = stage.session->next_frame(stage.state, clock);
    // The clock of frames that must come in time is the real one.
    clock += o.adapt ? frame.cost.seconds : 1 / script.frames_per_second;
    write_frame(o, frame, (std::filesystem::path(o.out) / fmt::format("{:05}.{}", i, o.format)).string());
    for (const ScriptMove& move : script.moves)
      if (move.screenshot && move.from == i) write_frame(o, frame, *move.screenshot);
    table += table_row(i, frame);
  }
  write_file((std::filesystem::path(o.out) / "frames.csv").string(), table);
  inform(fmt::format("wrote {} frames and frames.csv to {}", frames, o.out));
  return caught_interrupt() ? kExitSignalled + caught_interrupt() : 0;
}

}  // namespace glowworm
