// The public header glowworm/render.h.
#include "glowworm/render.h"

#include <algorithm>
#include <utility>

#include "api/scene_implementation.h"
#include "core/error.h"
#include "glowworm/glowworm.h"
#include "image/image.h"
#include "render/job.h"
#include "render/output.h"

namespace glowworm::api {

namespace {

RenderSettings settings_of(const RenderOptions& o) {
  if (o.width < 0 || o.height < 0) throw Error("the size of a picture is negative");
  RenderSettings s;
  s.integrator = o.path_tracing ? Integrator::path : Integrator::gather;
  if (!o.engine.empty()) s.engine = o.engine;
  s.width = o.width;
  s.height = o.height;
  s.samples = o.samples;
  s.gather = o.gather;
  s.photons = o.photons;
  s.progressive = o.progressive;
  s.seed = o.seed;
  s.time_limit_s = o.time_limit;
  s.noise_target = o.noise_target;
  s.memory_bytes = o.memory;
  s.camera = o.camera;
  s.aovs = o.aovs;
  return s;
}

}  // namespace

const char* version() { return glowworm::version(); }

std::span<const float> Picture::plane(const std::string& name) const {
  std::string names;
  for (const Plane& plane : planes) {
    if (plane.name == name) return plane.samples;
    names += (names.empty() ? "" : ", ") + plane.name;
  }
  throw Error("the picture has no plane '" + name + "'", "It has: " + names + ".");
}

void write_picture(const std::string& path, const Picture& picture) {
  glowworm::Image image(picture.width, picture.height);
  for (const Picture::Plane& plane : picture.planes) image.add_scalar(plane.name, plane.samples);
  write_image(path, image);
}

struct Render::Implementation {
  Implementation(const Scene& scene, const RenderOptions& options)
      : scene(scene), job(scene.implementation().scene, scene.implementation().tracer, settings_of(options)) {}
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
double Render::progress() const { return implementation_->job.progress(); }

Picture Render::picture() const {
  const Job& job = implementation_->job;
  const glowworm::Image image = make_image(job.snapshot(), job);
  Picture out{image.width(), image.height(), {}};
  for (const ImageChannel& channel : image.channels()) out.planes.push_back({channel.name, channel.samples});
  return out;
}

std::string Render::statistics() const {
  return statistics_json(implementation_->job, *implementation_->scene.implementation().tracer);
}

Picture render(const Scene& scene, const RenderOptions& options) {
  Render render(scene, options);
  render.wait();
  return render.picture();
}

}  // namespace glowworm::api
