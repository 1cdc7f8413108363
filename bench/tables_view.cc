// Frames a second of interactive sessions, beside those of [SF07] section 5.4 on four cores.
// usage: tables_view [FOLDER [SCENE...]]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/warp.h"
#include "gather/camera_pass.h"
#include "gather/gather_rays.h"
#include "import/import.h"
#include "photon/photon_tracer.h"
#include "scene/surface.h"
#include "session/camera_control.h"
#include "session/session.h"
#include "session/worker.h"
#include "support/recording.h"
#include "support/run_tables.h"
#include "support/table.h"

namespace {

using namespace glowworm;
using namespace glowworm::bench;

constexpr int kSide = 256;
constexpr std::uint64_t kPhotons = 500'000;
constexpr double kFramesPerSecond = 15;
constexpr int kRaysAloneRuns = 3;
/// Rays that are traced at once, where they are traced alone.
constexpr std::size_t kRaysAtOnce = 4096;

struct Row {
  ViewMode mode;
  std::uint32_t gather;
  int anew_runs, kept_runs;
  const char* name;
  const char* paper;         ///< frames a second on four cores
  double asked, asked_kept;  ///< frames a second
};

constexpr Row kRows[] = {{ViewMode::photons, 1, 5, 25, "photons shown", "10-11", 12, 60},
                         {ViewMode::gather, 16, 3, 5, "16 samples", "1.14", 4, 5},
                         {ViewMode::gather, 64, 2, 2, "64 samples", "0.34", 1.3, 1.3},
                         {ViewMode::gather, 100, 2, 2, "100 samples", "0.23", 0.9, 0.9}};

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

/// Wall seconds of closest hits alone, on all threads: the least of some runs.
double seconds_alone(const Tracer& tracer, const std::vector<Ray>& rays, RayOrder order) {
  std::vector<Hit> hits(rays.size());
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRaysAloneRuns; ++run) {
    const Spread s = measure_seconds(1, [&] {
      parallel_for(0, rays.size(), kRaysAtOnce, [&](std::size_t first, std::size_t last) {
        tracer.intersect(std::span(rays).subspan(first, last - first), std::span(hits).subspan(first, last - first),
                         order);
      });
    });
    least = std::min(least, s.median);
  }
  return least;
}

/// What closest hits alone take of a frame, in seconds: the least that tracing can take.
struct RaysAlone {
  double photons = 0, camera = 0, gather = 0;
};

/// As many rays as leave a photon, from where photons lie, in the order of their tracing, by the cosine law.
std::vector<Ray> photon_rays(const Tracer& tracer) {
  PhotonPassSettings settings;
  settings.photons = kPhotons;
  Statistics statistics;
  const PhotonPass pass = trace_photons(tracer, settings, statistics);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < pass.global.size(); ++i) {
    Sampler sampler(SamplerKind::sobol, 0, 0, static_cast<std::uint32_t>(i));
    const Vec3 n = pass.global.normal[i];
    rays.push_back({offset_origin(pass.global.position[i], n), 0,
                    Frame::from_normal(n).to_world(square_to_cosine_hemisphere(sampler.next2())),
                    std::numeric_limits<float>::infinity()});
  }
  return rays;
}

/// The camera rays and final gather rays of a frame.
RaysAlone rays_alone(const Tracer& tracer, const Camera& camera, const Row& row, double photon_seconds) {
  RaysAlone out;
  out.photons = photon_seconds;
  std::vector<Ray> rays;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const CameraRay ray = generate_ray(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f}, kSide,
                                         kSide, {0.5f, 0.5f});
      rays.push_back({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
    }
  out.camera = seconds_alone(tracer, rays, RayOrder::coherent);
  if (row.mode == ViewMode::photons) return out;
  CameraPassSettings settings;
  settings.width = settings.height = kSide;
  SlotRadiance radiance;
  FirstHit first_hit;
  Statistics statistics;
  const GatherPoints points =
      camera_pass(tracer, camera, {0, 0, kSide, kSide, 0, 1}, settings, radiance, first_hit, statistics);
  // In the portions and the order in which final gathering traces them.
  const std::size_t portion = std::max<std::size_t>(1, 32768 / row.gather);
  GatherRays gather;
  for (std::size_t first = 0; first < points.size(); first += portion) {
    std::vector<std::uint32_t> order;
    coherent_order(points, first, std::min(first + portion, points.size()), order);
    GatherRayMaker maker;
    maker.prepare(points, order, row.gather, 0);
    maker.create(0, row.gather, gather);
  }
  out.gather = seconds_alone(tracer, gather.rays, RayOrder::incoherent);
  return out;
}

std::vector<Cell> cells(const std::string& scene, const Row& row, const char* shows, bool anew, const RaysAlone& alone,
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
  const double rays = (anew ? alone.photons : 0) + alone.camera + alone.gather;
  return {scene,
          std::string(row.name),
          std::string(shows),
          std::string(anew ? "all anew" : "map kept"),
          spread_of(seconds).rate(1),
          Number{anew ? row.asked : row.asked_kept},
          std::string(row.paper),
          phase({Phase::trace_photons}),
          phase({Phase::build_photon_map}),
          phase({Phase::camera_pass}),
          phase({Phase::direct}),
          phase({Phase::gather_rays}),
          phase({Phase::reorder, Phase::density, Phase::completion}),
          Number{1e3 * rays},
          Number{1 / rays}};
}

void measure(Table& table, const std::string& path) {
  const auto scene = std::make_shared<const Scene>(load_scene(path, {}));
  const Tracer tracer(*scene);
  const double photon_seconds = seconds_alone(tracer, photon_rays(tracer), RayOrder::incoherent);
  Session session(scene, {});
  const ViewState initial = session.initial_state();
  double clock = 0;
  for (const Row& row : kRows) {
    const RaysAlone alone = rays_alone(tracer, initial.camera, row, photon_seconds);
    for (const bool all : {false, true}) {
      // The photon map shown has its light in one part; all light is shown by one row.
      if (all && row.gather != 16) continue;
      ViewState state = state_of(initial, row);
      state.part = all || row.mode == ViewMode::photons ? LightPart::all : LightPart::indirect;
      state.corners = all;
      session.next_frame(state, clock);
      for (const bool anew : {true, false}) {
        std::vector<ViewFrame> frames;
        for (int run = 0; run < (anew ? row.anew_runs : row.kept_runs); ++run) {
          move_on(state);
          if (anew) session.forget_photons();
          frames.push_back(session.next_frame(state, clock += 0.1));
        }
        table.add(cells(short_name(path), row, all ? "all light" : "as [SF07]", anew, alone, frames));
      }
    }
  }
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

  std::vector<ViewFrame> frames;         ///< of motion
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
      if (const auto frame = worker_.take_frame()) take(*frame, move != nullptr);
    }
  }

  void take(const WorkerFrame& frame, bool moves) {
    const Clock::time_point now = Clock::now();
    while (!waiting_.empty() && waiting_.front().number <= frame.number) {
      const double latency = std::chrono::duration<double>(now - waiting_.front().posted).count();
      if (moves) latencies.push_back(latency);
      if (moves && waiting_.front().number == frame.number) wanted_latencies.push_back(latency);
      waiting_.pop_front();
    }
    if (moves && frame.frame.moving) frames.push_back(frame.frame);
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
  if (light)
    motion.drag_light(kSeconds);
  else
    motion.move_camera(kSeconds);
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
             median([](const ViewFrame& f) { return f.photons; })});
}

void write_tables(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : "bench/results";
  std::vector<std::string> scenes(argv + std::min(argc, 2), argv + argc);
  if (scenes.empty()) scenes = {"builtin:cornell", "builtin:atrium"};
  Table table(
      "view", "Interactive sessions: 256x256 pixels, 500,000 photons, nothing reused across frames",
      {"scene", "mode", "light", "redone", "frames/s", "asked, frames/s", "[SF07], 4 cores, frames/s", "photons, ms",
       "map, ms", "camera, ms", "direct, ms", "gather rays, ms", "density, ms", "rays alone, ms", "limit, frames/s"});
  table.note(
      "Photons, map, ...: medians of wall time. 'map kept': only the camera moved. Samples: final gather rays of "
      "each pixel. 'as [SF07]': what they bring from the map; 'all light': with direct light by shadow rays, "
      "caustics, and a second gather in corners.");
  table.note(
      "Rays alone: Embree's closest hits of the same camera rays and final gather rays, and of as many rays as there "
      "are photons, from where photons lie: the least of three runs. Limit: frames a second if all else took no time.");
  for (const std::string& scene : scenes) measure(table, scene);
  table.write(folder);
  Table adapting("view_adapting",
                 fmt::format("Views in motion that adapt to {} frames a second: 256x256 pixels, 500,000 photons",
                             kFramesPerSecond),
                 {"scene", "mode", "what moves", "pictures/s", "state to its picture, ms", "input to picture, ms",
                  "scale", "gather rays", "photons"});
  adapting.note(
      "States come 60 times a second. State to its picture: of those that a picture was made of. Input to picture: of "
      "all states, to the first picture that is not older, so with the wait for the picture under way. Scale: of both "
      "sides of the picture.");
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
