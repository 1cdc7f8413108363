// Frames a second of interactive sessions, beside those of [SF07] section 5.4 on four cores.
// usage: tables_view [FOLDER [SCENE...]]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "import/import.h"
#include "session/camera_control.h"
#include "session/session.h"
#include "session/worker.h"
#include "support/recording.h"
#include "support/table.h"

namespace {

using namespace glowworm;
using namespace glowworm::bench;

constexpr int kSide = 256;
constexpr std::uint64_t kPhotons = 500'000;
constexpr double kFramesPerSecond = 15;

struct Row {
  ViewMode mode;
  std::uint32_t gather;
  int anew_runs, kept_runs;
  const char* name;
  const char* paper;  ///< frames a second on four cores
};

constexpr Row kRows[] = {{ViewMode::photons, 1, 5, 15, "photons shown", "10-11"},
                         {ViewMode::gather, 16, 3, 5, "16 samples", "1.14"},
                         {ViewMode::gather, 64, 2, 2, "64 samples", "0.34"},
                         {ViewMode::gather, 100, 2, 2, "100 samples", "0.23"}};

ViewState state_of(const Session& session, const Row& row) {
  ViewState state = session.initial_state();
  state.width = state.height = kSide;
  state.photons = kPhotons;
  state.mode = row.mode;
  state.gather = row.gather;
  state.reuse = false;
  return state;
}

/// A step to the side and a turn, small enough that every frame sees the same scene.
void move_on(ViewState& state) {
  state.camera = look(state.camera, nearest_up(state.camera), 0.002f, 0);
  state.camera = fly(state.camera, {0.0005f * state.pivot_distance, 0, 0});
}

std::vector<Cell> cells(const std::string& scene, const Row& row, const char* shows, const char* what,
                        const std::vector<ViewFrame>& frames) {
  std::vector<double> seconds;
  for (const ViewFrame& frame : frames) seconds.push_back(frame.cost.seconds);
  const auto phase = [&](std::vector<Phase> phases) -> Cell {
    std::vector<double> values;
    for (const ViewFrame& frame : frames) {
      double sum = 0;
      for (const Phase p : phases) sum += frame.cost.phase(p);
      values.push_back(1e3 * sum);
    }
    return Number{spread_of(values).median};
  };
  return {scene,
          std::string(row.name),
          std::string(shows),
          std::string(what),
          spread_of(seconds).rate(1),
          std::string(row.paper),
          phase({Phase::trace_photons}),
          phase({Phase::build_photon_map}),
          phase({Phase::camera_pass}),
          phase({Phase::direct}),
          phase({Phase::gather_rays}),
          phase({Phase::reorder, Phase::density, Phase::completion})};
}

void measure(Table& table, const std::string& path) {
  const auto scene = std::make_shared<const Scene>(load_scene(path, {}));
  Session session(scene, {});
  double clock = 0;
  for (const Row& row : kRows)
    for (const bool all : {false, true}) {
      // The photon map shown has its light in one part.
      if (all && row.mode == ViewMode::photons) continue;
      ViewState state = state_of(session, row);
      state.part = all ? LightPart::all : row.mode == ViewMode::photons ? LightPart::all : LightPart::indirect;
      state.corners = all;
      session.next_frame(state, clock);
      for (const bool anew : {true, false}) {
        std::vector<ViewFrame> frames;
        for (int run = 0; run < (anew ? row.anew_runs : row.kept_runs); ++run) {
          move_on(state);
          if (anew) session.forget_photons();
          frames.push_back(session.next_frame(state, clock += 0.1));
        }
        table.add(
            cells(short_name(path), row, all ? "all light" : "as [SF07]", anew ? "all anew" : "map kept", frames));
      }
    }
}

/// A view that turns for three seconds, as a window drives it: the worker's thread renders, states come 60 times a
/// second.
void measure_adapting(Table& table, const std::string& path, const Row& row) {
  SessionSettings settings;
  settings.adapt = true;
  settings.frames_per_second = kFramesPerSecond;
  SessionWorker worker(
      settings, [](const std::string& p) { return std::make_shared<const Scene>(load_scene(p, {})); }, [] {});
  worker.open(path);
  std::optional<LoadedScene> loaded;
  while (!(loaded = worker.take_scene())) {
    if (const auto error = worker.take_error()) throw Error(*error);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ViewState state = loaded->state;
  state.width = state.height = kSide;
  state.photons = kPhotons;
  state.mode = row.mode;
  state.gather = row.gather;
  worker.post(state, false);
  using Clock = std::chrono::steady_clock;
  const auto wait_until = [&](Clock::time_point end, std::vector<WorkerFrame>& frames, bool move) {
    while (Clock::now() < end) {
      if (move) {
        move_on(state);
        worker.post(state, true);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(16));
      if (auto frame = worker.take_frame()) frames.push_back(std::move(*frame));
    }
  };
  std::vector<WorkerFrame> resting, frames;
  wait_until(Clock::now() + std::chrono::seconds(4), resting, false);
  wait_until(Clock::now() + std::chrono::seconds(3), frames, true);
  std::vector<double> seconds, latency, scale, gather;
  for (const WorkerFrame& f : frames) {
    if (!f.frame.moving) continue;
    seconds.push_back(f.frame.cost.seconds);
    latency.push_back(1e3 * f.latency);
    scale.push_back(f.frame.effort.scale);
    gather.push_back(f.frame.effort.gather);
  }
  if (seconds.empty()) throw Error("no frame came while the view moved");
  table.add({short_name(path), std::string(row.name), Number{static_cast<double>(seconds.size()) / 3},
             spread_of(seconds).rate(1), spread_of(latency), Number{spread_of(scale).median},
             Number{spread_of(gather).median}});
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string folder = argc > 1 ? argv[1] : "bench/results";
  std::vector<std::string> scenes(argv + std::min(argc, 2), argv + argc);
  if (scenes.empty()) scenes = {"builtin:cornell", "builtin:atrium"};
  Table table("view", "Interactive sessions: 256x256 pixels, 500,000 photons, nothing reused across frames",
              {"scene", "mode", "light", "redone", "frames/s", "[SF07], 4 cores, frames/s", "photons, ms", "map, ms",
               "camera, ms", "direct, ms", "gather rays, ms", "density, ms"});
  table.note(
      "Photons, map, ...: medians of wall time. 'map kept': only the camera moved. Samples: final gather rays of "
      "each pixel. 'as [SF07]': what they bring from the map; 'all light': with direct light by shadow rays, "
      "caustics, and a second gather in corners.");
  for (const std::string& scene : scenes) measure(table, scene);
  table.write(folder);
  Table adapting("view_adapting",
                 fmt::format("Views in motion that adapt to {} frames a second: 256x256 pixels, 500,000 photons",
                             kFramesPerSecond),
                 {"scene", "mode", "pictures/s", "frames/s while one is rendered", "input to picture, ms", "scale",
                  "gather rays"});
  adapting.note(
      "Input to picture: from the newest state in a frame to the frame. Scale: of both sides of the picture.");
  for (const std::string& scene : scenes)
    for (const Row& row : kRows) measure_adapting(adapting, scene, row);
  adapting.write(folder);
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "tables_view: {}\n", error.what());
  return 1;
}
