// Frames a second of interactive sessions, beside those of [SF07] section 5.4 on four cores.
// usage: tables_view [FOLDER [SCENE...]]
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.h"
#include "import/import.h"
#include "session/camera_control.h"
#include "session/session.h"
#include "session/worker.h"
#include "support/frame_floor.h"
#include "support/recording.h"
#include "support/run_tables.h"
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
  const char* paper;         ///< frames a second on four cores
  double asked, asked_kept;  ///< frames a second
};

constexpr Row kRows[] = {{ViewMode::photons, 1, 9, 60, "photons shown", "10-11", 12, 60},
                         {ViewMode::gather, 16, 5, 9, "16 samples", "1.14", 4, 5},
                         {ViewMode::gather, 64, 3, 3, "64 samples", "0.34", 1.3, 1.3},
                         {ViewMode::gather, 100, 3, 3, "100 samples", "0.23", 0.9, 0.9}};

ViewState state_of(const ViewState& initial, const Row& row) {
  ViewState state = initial;
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

/// What frames took, and what the same takes that they cannot do without, frame by frame.
struct Measured {
  std::vector<ViewFrame> frames;
  std::vector<double> rays, surfaces, numbers, sums, bytes, map, emission;  ///< seconds, as FrameFloor
  std::vector<double> tested, search;  ///< what lookups take beside: sums of all pairs tested, and finding nothing
};

/// Whether a row has what was asked of it, or what keeps it from that.
std::string verdict(double frames_a_second, double rays, double least, double asked) {
  if (frames_a_second >= asked) return "reached";
  if (1 / rays < asked) return "rays alone forbid it";
  if (1 / least < asked) return "the least forbids it";
  return "not reached";
}

/// Seconds of all parts that a frame cannot do without, each in the middle of its runs.
double least_seconds(const Measured& m) {
  double sum = 0;
  for (const auto* part : {&m.rays, &m.surfaces, &m.numbers, &m.sums, &m.bytes, &m.map, &m.emission})
    sum += spread_of(*part).median;
  return sum;
}

/// What a frame that was asked for leaves beside the least, and what lookups and the map take beyond theirs.
std::vector<Cell> budget(const std::string& scene, const Row& row, const char* shows, bool anew, const Measured& m) {
  std::vector<double> seconds, maps;
  for (const ViewFrame& frame : m.frames) {
    seconds.push_back(frame.cost.seconds);
    maps.push_back(frame.cost.phase(Phase::build_photon_map));
  }
  const double asked = 1 / (anew ? row.asked : row.asked_kept), least = least_seconds(m);
  const double lookups = spread_of(m.tested).median - spread_of(m.sums).median + spread_of(m.search).median;
  const double map = spread_of(maps).median - spread_of(m.map).median;
  const auto milliseconds = [](double s) -> Cell { return Number{1e3 * s}; };
  return {scene,
          std::string(row.name),
          std::string(shows),
          std::string(anew ? "all anew" : "map kept"),
          milliseconds(asked),
          milliseconds(least),
          milliseconds(asked - least),
          milliseconds(lookups),
          milliseconds(map),
          milliseconds(spread_of(seconds).median)};
}

std::vector<Cell> cells(const std::string& scene, const Row& row, const char* shows, bool anew, const Measured& m) {
  std::vector<double> seconds;
  for (const ViewFrame& frame : m.frames) seconds.push_back(frame.cost.seconds);
  const auto phase = [&](std::vector<Phase> phases) -> Cell {
    std::vector<double> values;
    for (const ViewFrame& frame : m.frames) {
      double sum = 0;
      for (const Phase p : phases) sum += frame.cost.phase(p);
      values.push_back(1e3 * sum);
    }
    return Number{spread_of(values).median};
  };
  const double rays = spread_of(m.rays).median, surfaces = spread_of(m.surfaces).median,
               numbers = spread_of(m.numbers).median, sums = spread_of(m.sums).median,
               bytes = spread_of(m.bytes).median, map = spread_of(m.map).median,
               emission = spread_of(m.emission).median;
  const double least = least_seconds(m), asked = anew ? row.asked : row.asked_kept;
  const Spread rate = spread_of(seconds).rate(1);
  return {scene,
          std::string(row.name),
          std::string(shows),
          std::string(anew ? "all anew" : "map kept"),
          rate,
          Number{asked},
          verdict(rate.median, rays, least, asked),
          std::string(row.paper),
          phase({Phase::trace_photons}),
          phase({Phase::build_photon_map}),
          phase({Phase::camera_pass}),
          phase({Phase::direct}),
          phase({Phase::gather_rays}),
          phase({Phase::reorder, Phase::density, Phase::completion}),
          Number{1e3 * rays},
          Number{1e3 * surfaces},
          Number{1e3 * numbers},
          Number{1e3 * sums},
          Number{1e3 * bytes},
          Number{1e3 * map},
          Number{1e3 * emission},
          Number{1 / least},
          Number{1e3 * spread_of(m.tested).median},
          Number{1e3 * spread_of(m.search).median}};
}

/// Frames, and after each what it could not do without, so that both meet the machine as it is then.
Measured measure_frames(Session& session, ViewState& state, FrameFloor& floor, bool anew, int runs, double& clock) {
  Measured m;
  for (int run = 0; run < runs; ++run) {
    move_on(state);
    if (anew) session.forget_photons();
    m.frames.push_back(session.next_frame(state, clock += 0.1));
    m.frames.back().image = ViewImage();
    const FrameCost& cost = m.frames.back().cost;
    m.rays.push_back(floor.rays(anew));
    m.surfaces.push_back(floor.surfaces(anew));
    m.numbers.push_back(floor.numbers(anew));
    m.sums.push_back(floor.sums(cost.count(Counter::shader_operations)));
    m.bytes.push_back(floor.bytes(cost.count(Counter::query_points), anew));
    m.map.push_back(anew ? floor.map() : 0);
    m.emission.push_back(anew ? floor.emission() : 0);
    m.tested.push_back(floor.sums(cost.count(Counter::pairs_tested)));
    m.search.push_back(floor.search());
  }
  return m;
}

void measure(Table& table, Table& budgets, const std::string& path) {
  const auto scene = std::make_shared<const Scene>(load_scene(path, {}));
  const Tracer tracer(*scene);
  Session session(scene, {});
  const ViewState initial = session.initial_state();
  FrameFloor floor(tracer, initial.camera, kSide, kPhotons);
  double clock = 0;
  for (const Row& row : kRows) {
    floor.choose_gather(row.mode == ViewMode::photons ? 0 : row.gather);
    for (const bool all : {false, true}) {
      // The photon map shown has its light in one part; all light is shown by one row.
      if (all && row.gather != 16) continue;
      ViewState state = state_of(initial, row);
      state.part = all || row.mode == ViewMode::photons ? LightPart::all : LightPart::indirect;
      state.corners = all;
      session.next_frame(state, clock);
      const char* shows = all ? "all light" : "as [SF07]";
      for (const bool anew : {true, false}) {
        const Measured m = measure_frames(session, state, floor, anew, anew ? row.anew_runs : row.kept_runs, clock);
        table.add(cells(short_name(path), row, shows, anew, m));
        budgets.add(budget(short_name(path), row, shows, anew, m));
      }
    }
  }
}

/// Seconds that this machine's processors stood ready but were given to other machines, all added up; 0 where the
/// system does not say.
double stolen_seconds() {
  std::ifstream file("/proc/stat");
  std::string name;
  double ticks = 0;
  file >> name;
  for (int field = 0; field < 8; ++field) file >> ticks;  // the eighth is "steal": proc(5)
  return file ? ticks / static_cast<double>(sysconf(_SC_CLK_TCK)) : 0;
}

/// A view in motion, as a window drives it: the worker's thread renders, states come 60 times a second.
class Motion {
 public:
  Motion(const std::string& path, const Row& row) : worker_(settings(), open, [] {}) {
    worker_.open(path);
    std::optional<LoadedScene> loaded;
    while (!(loaded = worker_.take_scene())) {
      if (const auto error = worker_.take_error()) throw Error(*error);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    light_has_place_ = !loaded->lights.empty() && loaded->lights[0].has_place();
    step_ = 0.002f * loaded->scene->radius();
    state_ = state_of(loaded->state, row);
    state_.reuse = true;
    post(false);
    rest(1.5);
  }

  /// Nothing changes for so many seconds.
  void rest(double seconds) { run(seconds, nullptr); }
  /// The camera moves.
  void move_camera(double seconds) {
    run(seconds, [this] { move_on(state_); });
  }
  /// A light is dragged, or the sun turned.
  void drag_light(double seconds) {
    run(seconds, [this] {
      LightEdit& edit = state_.lights.at(0);
      if (light_has_place_)
        edit.move.x += state_.lights[0].move.x > 20 * step_ ? -20 * step_ : step_;
      else
        edit.turn.y += 0.005f;
    });
  }

  std::vector<ViewFrame> frames;         ///< of motion, without their pictures
  std::vector<double> latencies;         ///< seconds from each state posted to the first picture of it, or a newer one
  std::vector<double> wanted_latencies;  ///< the same of those states alone that a picture was made of

 private:
  using Clock = std::chrono::steady_clock;

  static SessionSettings settings() {
    SessionSettings settings;
    settings.adapt = true;
    settings.frames_per_second = kFramesPerSecond;
    return settings;
  }
  static std::shared_ptr<const Scene> open(const std::string& path) {
    return std::make_shared<const Scene>(load_scene(path, {}));
  }

  void post(bool interacting) { waiting_.push_back({worker_.post(state_, interacting), Clock::now()}); }

  /// @param move changes the state; none: nothing does
  void run(double seconds, const std::function<void()>& move) {
    const Clock::time_point end =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    Clock::time_point next = Clock::now();
    while (Clock::now() < end) {
      if (move && Clock::now() >= next) {
        move();
        post(true);
        next += std::chrono::microseconds(16'667);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (const auto error = worker_.take_error()) throw Error(*error);
      if (auto frame = worker_.take_frame()) take(*frame, move != nullptr);
    }
  }

  void take(WorkerFrame& frame, bool moves) {
    const Clock::time_point now = Clock::now();
    while (!waiting_.empty() && waiting_.front().number <= frame.number) {
      const double latency = std::chrono::duration<double>(now - waiting_.front().posted).count();
      if (moves) latencies.push_back(latency);
      if (moves && waiting_.front().number == frame.number) wanted_latencies.push_back(latency);
      waiting_.pop_front();
    }
    frame.frame.image = ViewImage();  // a hundred of them would be a third of a gigabyte of fresh memory
    if (moves && frame.frame.moving) frames.push_back(std::move(frame.frame));
  }

  struct Posted {
    std::uint64_t number;
    Clock::time_point posted;
  };
  SessionWorker worker_;
  ViewState state_;
  bool light_has_place_ = false;
  float step_ = 0;
  std::deque<Posted> waiting_;
};

void measure_adapting(Table& table, const std::string& path, const Row& row, bool light) {
  constexpr double kSeconds = 2.5;
  Motion motion(path, row);
  const double stolen_before = stolen_seconds();
  if (light)
    motion.drag_light(kSeconds);
  else
    motion.move_camera(kSeconds);
  const double stolen = stolen_seconds() - stolen_before;
  if (motion.frames.empty()) throw Error("no frame came while the view moved");
  const auto median = [&](auto&& value) -> Cell {
    std::vector<double> values;
    for (const ViewFrame& frame : motion.frames) values.push_back(static_cast<double>(value(frame)));
    return Number{spread_of(values).median};
  };
  table.add({short_name(path), std::string(row.name), std::string(light ? "a light" : "the camera"),
             Number{static_cast<double>(motion.frames.size()) / kSeconds},
             spread_of(motion.wanted_latencies).scaled(1e3), spread_of(motion.latencies).scaled(1e3),
             median([](const ViewFrame& f) { return f.effort.scale; }),
             median([](const ViewFrame& f) { return f.effort.gather; }),
             median([](const ViewFrame& f) { return f.photons; }), Number{1e3 * stolen, 2}});
}

void write_tables(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : "bench/results";
  std::vector<std::string> scenes(argv + std::min(argc, 2), argv + argc);
  if (scenes.empty()) scenes = {"builtin:cornell", "builtin:atrium"};
  Table table("view", "Interactive sessions: 256x256 pixels, 500,000 photons, nothing reused across frames",
              {"scene",
               "mode",
               "light",
               "redone",
               "frames/s",
               "asked, frames/s",
               "what was asked",
               "[SF07], 4 cores, frames/s",
               "photons, ms",
               "map, ms",
               "camera, ms",
               "direct, ms",
               "gather rays, ms",
               "density, ms",
               "rays alone, ms",
               "surfaces, ms",
               "random numbers, ms",
               "sums alone, ms",
               "bytes, ms",
               "least map, ms",
               "emission, ms",
               "limit, frames/s",
               "pairs tested, ms",
               "nothing found, ms"});
  table.note(
      "Photons, map, ...: medians of wall time. 'map kept': only the camera moved. Samples: final gather rays of "
      "each pixel. 'as [SF07]': what they bring from the map; 'all light': with direct light by shadow rays, "
      "caustics, and a second gather in corners.");
  table.note(
      "Rays alone: Embree's closest hits of the same camera and final gather rays, and of as many rays as there are "
      "photons, from where photons lie. Surfaces: position, normal and reflectance where they hit; of photons with the "
      "direction in which paths go on, by the vector kernel. Random numbers: directions of gather rays, and Sobol' "
      "pairs of photons. Sums alone: the frame's shader operations where every pair tested is used. Bytes: query "
      "points and photons written once. Least map: photons counted by cell and moved once. Emission: of all light "
      "paths, by the vector kernels, from numbers in the first cache. Each is measured after each frame; limit: frames "
      "a second if all else took no time. 'forbids it': rays alone, or all seven, take longer than a frame that was "
      "asked for.");
  table.note(
      "What lookups take beside the sums: pairs tested, the sums of all pairs that are tested; nothing found, the same "
      "query points looked up among the same photons with radii of a ten-thousandth.");
  Table budgets("view_budget", "What frames that were asked for leave beside the least",
                {"scene", "mode", "light", "redone", "a frame asked for, ms", "the least, ms", "is left, ms",
                 "lookups beyond sums, ms", "map beyond the least, ms", "the frame, ms"});
  budgets.note(
      "The least: the seven parts of the table of frames. Lookups beyond sums: pairs tested that do not count, and the "
      "lookup that finds nothing. Map beyond the least: radii and index as sessions make them.");
  for (const std::string& scene : scenes) measure(table, budgets, scene);
  table.write(folder);
  budgets.write(folder);
  Table adapting("view_adapting",
                 fmt::format("Views in motion that adapt to {} frames a second: 256x256 pixels, 500,000 photons",
                             kFramesPerSecond),
                 {"scene", "mode", "what moves", "pictures/s", "state to its picture, ms", "input to picture, ms",
                  "scale", "gather rays", "photons", "stolen, ms"});
  adapting.note(
      "States come 60 times a second. State to its picture: of those that a picture was made of. Input to picture: of "
      "all states, to the first picture that is not older, so with the wait for the picture under way. Scale: of both "
      "sides of the picture. Stolen: processor time that the machine below gave to others meanwhile.");
  for (const std::string& scene : scenes)
    for (const bool light : {false, true})
      for (const Row& row : kRows)
        if (row.gather != 64) measure_adapting(adapting, scene, row, light);
  adapting.write(folder);
}

}  // namespace

int main(int argc, char** argv) {
  return glowworm::bench::run_tables("tables_view", [&] { write_tables(argc, argv); });
}
