// Helpers for tests that render: pictures, their means and confidence intervals.
#pragma once
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "control/job.h"
#include "core/rgb.h"
#include "scene/scene.h"
#include "trace/tracer.h"

namespace glowworm {

/// A scene ready to be rendered any number of times.
struct Stage {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;

  explicit Stage(SceneDescription description) : Stage(std::make_shared<const Scene>(std::move(description))) {}
  explicit Stage(std::shared_ptr<const Scene> whole)
      : scene(std::move(whole)), tracer(std::make_shared<const Tracer>(*scene)) {}

  Film render(const RenderSettings& settings) const {
    Job job(scene, tracer, settings);
    job.wait();
    return job.snapshot();
  }
};

/// A square picture by path tracing.
inline RenderSettings by_path(int side, std::uint32_t samples) {
  RenderSettings s;
  s.integrator = Integrator::path;
  s.width = s.height = side;
  s.samples = samples;
  return s;
}

/// A square picture by photon mapping.
inline RenderSettings by_photons(int side, std::uint32_t samples, std::uint32_t gather, std::uint64_t photons,
                                 const char* engine = "knn") {
  RenderSettings s;
  s.width = s.height = side;
  s.samples = samples;
  s.gather = gather;
  s.photons = photons;
  s.engine = engine;
  s.filter = Filtering::off;  // Most tests look at the samples themselves.
  return s;
}

/// A mean over pixels, for each channel.
struct Mean {
  double value[3] = {0, 0, 0};
  double luminance() const { return 0.2126 * value[0] + 0.7152 * value[1] + 0.0722 * value[2]; }
};

inline Mean mean(const std::vector<RGB>& pixels) {
  Mean m;
  for (const RGB& p : pixels)
    for (int c = 0; c < 3; ++c) m.value[c] += p[c];
  for (double& v : m.value) v /= static_cast<double>(pixels.size());
  return m;
}

inline std::vector<RGB> pixels(const Film& film, bool indirect_only = false) {
  std::vector<RGB> out;
  for (std::size_t i = 0; i < film.pixel_count(); ++i) out.push_back(film.radiance(i, indirect_only));
  return out;
}

inline Mean mean(const Film& film, bool indirect_only = false) { return mean(pixels(film, indirect_only)); }

/// An orthographic camera that sees a square of that side around `target`, from `distance` metres away in the
/// direction `towards_viewer` (unit).
inline Camera square_view(Vec3 target, Vec3 towards_viewer, float distance, float side) {
  const Vec3 up = std::abs(towards_viewer.z) > 0.9f ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  Camera camera = look_at(target + towards_viewer * distance, target, up, 45);
  camera.name = "square";
  camera.kind = CameraKind::orthographic;
  camera.half_extent = side / 2;
  return camera;
}

}  // namespace glowworm
