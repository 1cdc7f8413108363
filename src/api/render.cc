// The public header glowworm/render.h.
#include "glowworm/render.h"

#include <fmt/format.h>

#include <cmath>

#include "api/picture_implementation.h"
#include "api/run_job.h"
#include "api/scene_implementation.h"
#include "control/job.h"
#include "control/job_report.h"
#include "core/error.h"
#include "core/names.h"
#include "core/version.h"
#include "density/engine.h"
#include "film/output.h"
#include "glowworm/glowworm.h"
#include "settings/options.h"

namespace glowworm::api {

namespace {

const std::string kDashes = "--";

void set_option(RenderSettings& settings, const std::string& name, const std::string& text, Command command) {
  const std::vector<std::string> names = option_names(command);
  const std::string& known = names[name_index("option", name, names)];
  for (const Option& option : render_options())
    if (option.name == kDashes + known) option.parse(settings, option.is_flag && text.empty() ? "given" : text);
}

/// What only pictures have.
void set_picture(RenderSettings& s, const RenderOptions& o) {
  if (o.width < 0 || o.height < 0) throw Error("the size of a picture is negative");
  if (const auto& c = o.crop) {
    // NaN is refused, too.
    if (!(c->x0 >= 0 && c->y0 >= 0 && c->x0 < c->x1 && c->y0 < c->y1 && c->x1 <= 1 && c->y1 <= 1))
      throw Error("the crop is not a part of the picture",
                  "Give fractions from 0 (left, top) to 1, for example 0.25, 0, 0.75, 0.5.");
    s.crop = {c->x0, c->y0, c->x1, c->y1};
  }
  s.width = o.width;
  s.height = o.height;
  s.camera = o.camera;
  s.aovs = o.aovs;
}

}  // namespace

std::vector<std::string> option_names(Command command) {
  std::vector<std::string> names;
  // Threads are the process's: set_threads().
  for (const Option& option : render_options())
    if (option.is_on_command_line() && option.is_of(command) && option.name != kDashes + "threads")
      names.push_back(std::string(option.name).substr(kDashes.size()));
  return names;
}

RenderSettings settings_of(const RenderOptions& o, Command command) {
  RenderSettings s;
  s.integrator = o.integrator;
  s.engine = engine_name(o.engine);
  if (!o.filter) s.filter = Filtering::off;
  s.samples = o.samples;
  s.gather = o.gather;
  s.photons = o.photons;
  s.progressive = o.progressive;
  s.seed = o.seed;
  s.time_limit_s = o.time_limit;
  s.noise_target = o.noise_target;
  s.memory_bytes = o.memory;
  if (command == Command::render) set_picture(s, o);
  for (const auto& [name, text] : o.more) set_option(s, name, text, command);
  s.separate_layers = !s.aovs.empty();
  return s;
}

void attend(Job& job, const std::function<void(double)>& progress) {
  constexpr double kInterval = 0.1;  // seconds
  while (progress && !job.wait_for(kInterval)) progress(job.progress());
  job.wait();
}

const char* version() { return glowworm::version(); }

std::vector<std::string> aov_names() { return glowworm::aov_names(); }

std::vector<std::string> render_option_names() { return option_names(Command::render); }

std::uint64_t parse_count(const std::string& text) {
  const double value = glowworm::parse_count(text);
  constexpr double kExact = 9007199254740992.0;  // whole doubles up to it are exact
  if (!(value >= 0 && value <= kExact && value == std::floor(value)))
    throw Error("'" + text + "' is not a count", "Give a whole number of 0 or more; 2k is 2000 and 1.5M is 1500000.");
  return static_cast<std::uint64_t>(value);
}

struct Render::Implementation {
  Implementation(const Scene& scene, const RenderOptions& options)
      : scene(scene),
        job(scene.implementation().scene, scene.implementation().tracer, settings_of(options, Command::render)) {}
  Scene scene;
  Job job;
};

Render::Render(const Scene& scene, const RenderOptions& options)
    : implementation_(std::make_unique<Implementation>(scene, options)) {}
Render::~Render() = default;
Render::Render(Render&&) noexcept = default;
Render& Render::operator=(Render&&) noexcept = default;

void Render::cancel() { implementation_->job.cancel(); }
void Render::wait() { implementation_->job.wait(); }
bool Render::done() const { return implementation_->job.done(); }
bool Render::cancelled() const { return implementation_->job.ending() == Ending::cancelled; }

bool Render::wait_for(double seconds) { return implementation_->job.wait_for(seconds); }
double Render::progress() const { return implementation_->job.progress(); }

Picture Render::picture() const {
  const Job& job = implementation_->job;
  return outer(make_image(job.snapshot(), job));
}

RenderStatistics Render::statistics() const {
  return statistics_of(implementation_->job, *implementation_->scene.implementation().tracer);
}

struct FrameSequence::Implementation {
  std::shared_ptr<const glowworm::Scene> scene;  ///< with the cameras of all frames
  std::shared_ptr<const glowworm::Tracer> tracer;
  RenderSettings settings;
  std::vector<std::string> cameras;
  std::shared_ptr<JobMaps> maps;  ///< of the frames so far
};

FrameSequence::FrameSequence(const Scene& scene, std::span<const Camera> cameras, const RenderOptions& options)
    : implementation_(std::make_unique<Implementation>()) {
  if (cameras.empty()) throw Error("a sequence has no cameras", "Give one for each frame.");
  Implementation& own = *implementation_;
  std::string prefix = "frame ";
  for (const std::string& name : scene.cameras())
    if (name.starts_with(prefix)) prefix = name + ": ";
  std::vector<Camera> named(cameras.begin(), cameras.end());
  for (std::size_t i = 0; i < named.size(); ++i) {
    named[i].name = prefix + std::to_string(i);
    own.cameras.push_back(named[i].name);
  }
  const Scene with_all = scene.with_cameras(named);
  own.scene = with_all.implementation().scene;
  own.tracer = with_all.implementation().tracer;
  own.settings = settings_of(options, Command::render);
  own.settings.guide_cameras = guide_cameras(own.cameras);
}
FrameSequence::~FrameSequence() = default;
FrameSequence::FrameSequence(FrameSequence&&) noexcept = default;
FrameSequence& FrameSequence::operator=(FrameSequence&&) noexcept = default;

std::size_t FrameSequence::size() const { return implementation_->cameras.size(); }

Picture FrameSequence::render(std::size_t frame, const std::function<void(double)>& progress) {
  Implementation& own = *implementation_;
  if (frame >= size()) throw Error(fmt::format("there is no frame {}: the sequence has {}", frame, size()));
  RenderSettings settings = own.settings;
  settings.camera = own.cameras[frame];
  settings.frame = static_cast<std::uint32_t>(frame);
  Job job(own.scene, own.tracer, settings, nullptr, {}, nullptr, nullptr, own.maps);
  attend(job, progress);
  own.maps = job.maps();
  return outer(make_image(job.snapshot(), job));
}

Picture render(const Scene& scene, const RenderOptions& options, const std::function<void(double)>& progress) {
  Job job(scene.implementation().scene, scene.implementation().tracer, settings_of(options, Command::render));
  attend(job, progress);
  return outer(make_image(job.snapshot(), job));
}

}  // namespace glowworm::api
