// One frame of a session on one thread, for scripts/count-instructions: prints what was counted.
//
// usage: frame_once [SCENE [anew|kept [GATHER]]]     (default: builtin:cornell anew 0)
//   anew: photons are traced and the map is built, too; GATHER  final gather rays of a pixel; 0: the photon map is
//   shown. 256x256 pixels, 500,000 photons, what gather rays bring from the map alone: as the table of bench/tables.cc.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "import/import.h"
#include "session/camera_control.h"
#include "session/session.h"

namespace {

using namespace glowworm;

/// The frame that is counted.
[[gnu::noinline]] ViewFrame counted_frame(Session& session, const ViewState& state) {
  return session.next_frame(state, 1);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> asked(argv + 1, argv + argc);
  const auto argument = [&](std::size_t i, const char* otherwise) { return i < asked.size() ? asked[i] : otherwise; };
  set_thread_count(1);
  const std::string path = argument(0, "builtin:cornell"), redone = argument(1, "anew");
  const auto gather = static_cast<std::uint32_t>(std::stoul(argument(2, "0")));
  Session session(std::make_shared<const Scene>(load_scene(path, {})), {});
  ViewState state = session.initial_state();
  state.width = state.height = 256;
  state.photons = 500'000;
  state.mode = gather > 0 ? ViewMode::gather : ViewMode::photons;
  state.gather = std::max(gather, 1u);
  state.part = gather > 0 ? LightPart::indirect : LightPart::all;
  state.secondary_gather = state.reuse = state.filter = false;
  session.next_frame(state, 0);
  // Arrays of a frame are made again in those of the frame before.
  state.camera = look(state.camera, nearest_up(state.camera), 0.002f, 0);
  if (redone == "anew") session.forget_photons();
  session.next_frame(state, 0.5);
  state.camera = look(state.camera, nearest_up(state.camera), 0.002f, 0);
  if (redone == "anew") session.forget_photons();
  const ViewFrame frame = counted_frame(session, state);
  const FrameCost& cost = frame.cost;
  fmt::print(
      "engine {} photons {} photons_emitted {} query_points {} shader_operations {} pairs_tested {} milliseconds "
      "{:.1f}\n",
      frame.engine, frame.photons, cost.count(Counter::photons_emitted), cost.count(Counter::query_points),
      cost.count(Counter::shader_operations), cost.count(Counter::pairs_tested), 1e3 * cost.seconds);
}
