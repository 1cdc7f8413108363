#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <thread>

#include "apps/commands.h"
#include "apps/progress_bar.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "import/import.h"
#include "kernels/simd.h"
#include "render/job.h"
#include "render/output.h"

namespace glowworm {

namespace {

struct RenderOptions {
  std::string scene;
  std::vector<std::string> outputs;
  std::string samples = "auto", gather = "auto", photons = "auto", nearest = "auto";
  std::string size, memory, time, statistics, simd = "auto", tone = "filmic", precision = "half";
  float exposure = 0;
  bool verbose = false, quiet = false, no_secondary = false;
  RenderSettings settings;
};

volatile std::sig_atomic_t interrupted = 0;

void on_interrupt(int) { interrupted = 1; }

/// The first Ctrl-C asks the render to stop and write what it has; a second one ends the program at once.
void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

std::uint64_t parse_count(const std::string& text, const char* option, std::uint64_t largest) {
  if (text == "auto") return 0;
  std::size_t used = 0;
  double value = -1;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
  }
  const std::string unit = used < text.size() ? text.substr(used) : "";
  const double factor = unit == "k" ? 1e3 : unit == "M" ? 1e6 : unit.empty() ? 1 : -1;
  if (factor < 0 || !(value * factor >= 1) || value * factor > static_cast<double>(largest))
    throw Error(fmt::format("{} '{}' is not a count", option, text),
                fmt::format("Give 'auto' or a number from 1 to {}, for example 500k.", largest));
  return static_cast<std::uint64_t>(value * factor);
}

std::uint64_t parse_bytes(const std::string& text) {
  std::size_t used = 0;
  double value = -1;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
  }
  const std::string unit = text.substr(std::min(used, text.size()));
  const double factor = unit == "K" || unit == "KB"   ? 1e3
                        : unit == "M" || unit == "MB" ? 1e6
                        : unit == "G" || unit == "GB" ? 1e9
                        : unit == "T" || unit == "TB" ? 1e12
                        : unit.empty()                ? 1
                                                      : -1;
  if (factor < 0 || !(value * factor >= 1e6) || value * factor > 1e15)
    throw Error(fmt::format("--memory '{}' is not a size", text), "Give at least 1M, for example 512M or 4G.");
  return static_cast<std::uint64_t>(value * factor);
}

double parse_seconds(const std::string& text) {
  std::size_t used = 0;
  double value = -1;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
  }
  const std::string unit = text.substr(std::min(used, text.size()));
  const double factor = unit == "s" || unit.empty() ? 1 : unit == "m" || unit == "min" ? 60 : unit == "h" ? 3600 : -1;
  if (factor < 0 || !(value > 0) || value * factor > 1e9)
    throw Error(fmt::format("--time '{}' is not a time", text), "Give for example 60s, 5m or 2h.");
  return value * factor;
}

void parse_size(const std::string& text, RenderSettings& settings) {
  char tail = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &settings.width, &settings.height, &tail) != 2 || settings.width < 1 ||
      settings.height < 1)
    throw Error(fmt::format("--size '{}' is not a size", text), "Give WIDTHxHEIGHT in pixels, for example 1280x720.");
}

void resolve_options(RenderOptions& o) {
  RenderSettings& s = o.settings;
  s.samples = static_cast<std::uint32_t>(parse_count(o.samples, "--samples", 1u << 24));
  s.gather = static_cast<std::uint32_t>(parse_count(o.gather, "--gather", 1u << 20));
  s.photons = parse_count(o.photons, "--photons", 1u << 30);
  s.nearest = static_cast<std::uint32_t>(parse_count(o.nearest, "--nearest", 100'000));
  if (!o.size.empty()) parse_size(o.size, s);
  if (!o.memory.empty()) s.memory_bytes = parse_bytes(o.memory);
  if (!o.time.empty()) s.time_limit_s = parse_seconds(o.time);
  s.secondary_gather = !o.no_secondary;
  if (o.outputs.empty()) o.outputs.push_back("out.exr");
  for (const std::string& path : o.outputs) {
    const std::string ending = std::filesystem::path(path).extension();
    if (ending != ".exr" && ending != ".png")
      throw Error(fmt::format("'{}' ends neither in .exr nor in .png", path),
                  "Give -o a name with one of these endings.");
    // Found out now rather than after the render.
    const AtomicFile probe(path);
  }
}

void write_outputs(const RenderOptions& o, const Job& job, const Tracer& tracer, Statistics& statistics) {
  {
    const PhaseTimer timer(statistics, Phase::output);
    const Image image = make_image(job.snapshot(), job);
    for (const std::string& path : o.outputs) {
      if (std::filesystem::path(path).extension() == ".exr")
        write_exr(path, image, o.precision == "float" ? ExrPrecision::single : ExrPrecision::half);
      else
        write_png(path, image, o.tone == "srgb" ? ToneCurve::srgb : ToneCurve::filmic, o.exposure);
      inform(fmt::format("wrote {}", path));
    }
  }
  if (!o.statistics.empty()) write_file(o.statistics, statistics_json(job, tracer) + "\n");
}

std::string describe(const RenderSettings& s, const Scene& scene) {
  std::string text = fmt::format("{}: {} triangles, {}x{} pixels, {} samples", scene.name(),
                                 scene.geometry().triangle_count(), s.width, s.height, s.samples);
  if (s.integrator == Integrator::path) return text + ", path tracing";
  return text +
         fmt::format(" x {} gather rays, {} photons, k = {}, engine {}", s.gather, s.photons, s.nearest, s.engine);
}

/// Waits for the job, showing progress; hands a Ctrl-C on to it.
void attend(Job& job, bool quiet) {
  ProgressBar bar(!quiet);
  while (!job.done()) {
    if (interrupted) job.cancel();
    bar.update(job.progress(), fmt::format("pass {}", job.passes() + 1));
    std::this_thread::sleep_for(std::chrono::milliseconds(job.seconds() < 2 ? 5 : 50));
  }
  bar.finish();
  job.wait();
}

int run_render(RenderOptions& o) {
  set_log_level(o.quiet ? LogLevel::quiet : o.verbose ? LogLevel::verbose : LogLevel::normal);
  set_thread_count(o.settings.threads);
  set_simd(o.simd);
  resolve_options(o);
  const auto load_start = std::chrono::steady_clock::now();
  ImportOptions import_options;
  import_options.texture_memory_bytes = o.settings.memory_bytes / 4;
  const auto scene = std::make_shared<const Scene>(load_scene(o.scene, import_options));
  const auto loaded = std::chrono::steady_clock::now();
  for (const std::string& note : scene->notes()) inform("note: " + note);
  const auto tracer = std::make_shared<const Tracer>(*scene);
  const auto built = std::chrono::steady_clock::now();
  catch_interrupts();
  Job job(scene, tracer, o.settings);
  job.statistics().add_time(Phase::load, std::chrono::duration<double>(loaded - load_start).count());
  job.statistics().add_time(Phase::build_accel, std::chrono::duration<double>(built - loaded).count());
  inform(describe(job.settings(), *scene));
  attend(job, o.quiet);
  write_outputs(o, job, *tracer, job.statistics());
  inform(fmt::format("{} passes in {:.2f} s", job.passes(), job.seconds()));
  if (job.ending() != Ending::cancelled) return 0;
  warn("interrupted: the files hold the image so far");
  return kExitInterrupted;
}

}  // namespace

void add_render_command(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* c = program.add_subcommand("render", "Renders a scene to an image.");
  RenderSettings& s = options->settings;
  c->add_option("scene", options->scene, "A file (.pbrt .gltf .glb .obj .ply .fbx ...) or builtin:NAME")->required();
  c->add_option("-o,--output", options->outputs, "Image to write, .exr or .png; may be given several times (out.exr)");
  const std::map<std::string, Integrator> integrators = {
      {"photon", Integrator::photon}, {"path", Integrator::path}, {"photons", Integrator::photons}};
  c->add_option("--integrator", s.integrator,
                "photon: photon mapping; path: path tracing, the reference; photons: the photon map itself, shown")
      ->transform(CLI::CheckedTransformer(integrators))
      ->option_text("photon|path|photons");
  c->add_option("--engine", s.engine, "Density engine: auto, or one of those that --engine help lists");
  c->add_option("--samples", options->samples, "Camera samples of each pixel, or auto");
  c->add_option("--gather", options->gather, "Final gather rays of each camera sample, or auto");
  c->add_option("--photons", options->photons, "Photons in the map, for example 500k or 2M, or auto");
  c->add_option("--nearest", options->nearest, "Photons that an estimate should catch (k), or auto");
  c->add_option("--size", options->size, "Picture size in pixels, WIDTHxHEIGHT");
  c->add_option("--camera", s.camera, "Camera of the scene by name (the first)");
  c->add_option("--seed", s.seed, "Seed of all random numbers: the same seed gives the same image, bit for bit");
  c->add_option("--threads", s.threads, "Threads (one for each core)")->check(CLI::Range(0, 1024));
  c->add_option("--memory", options->memory, "Memory to stay within, for example 4G (half of the machine's)");
  c->add_option("--time", options->time, "Stop after this time, for example 60s, 5m");
  c->add_option("--noise", s.noise_target, "Stop at this relative standard error, for example 0.01")
      ->check(CLI::PositiveNumber);
  c->add_flag("--progressive", s.progressive, "New photons and smaller radii in every pass: converges to the truth");
  c->add_flag("--indirect-only", s.indirect_only, "Only the light gathered over surfaces");
  c->add_flag("--no-secondary-gather", options->no_secondary, "Look photons up in corners, too (for comparison)");
  c->add_option("--aov", s.aovs, "Layers beside the image: emitted,direct,indirect,caustic,albedo,normal,depth")
      ->delimiter(',');
  c->add_option("--precision", options->precision, "Numbers of the EXR file: half or float")
      ->check(CLI::IsMember({"half", "float"}));
  c->add_option("--tone", options->tone, "Tone curve of the PNG file: filmic or srgb")
      ->check(CLI::IsMember({"filmic", "srgb"}));
  c->add_option("--exposure", options->exposure, "Exposure of the PNG file in stops");
  c->add_option("--simd", options->simd, "Instruction set of the kernels (auto, avx512, avx2, sse4, scalar)");
  c->add_option("--stats", options->statistics, "Write statistics as JSON to this file");
  c->add_flag("-v,--verbose", options->verbose, "Say more");
  c->add_flag("-q,--quiet", options->quiet, "Say warnings and errors only");
  c->callback([options, &exit_status] { exit_status = run_render(*options); });
}

}  // namespace glowworm
