#include "session/view_state.h"

#include <limits>

namespace glowworm {

RenderSettings render_settings(const ViewState& state) {
  RenderSettings settings;
  settings.integrator = state.mode == ViewMode::photons ? Integrator::photons : Integrator::gather;
  settings.engine = state.engine;
  settings.kernel = state.kernel;
  settings.photons = state.photons;
  settings.nearest = state.nearest;
  settings.secondary_gather = state.secondary_gather;
  settings.width = state.width;
  settings.height = state.height;
  settings.filter = state.filter ? Filtering::automatic : Filtering::off;
  return settings;
}

float pivot_distance(const Tracer& tracer, const Camera& camera) {
  const CameraRay ray = generate_ray(camera, {0.5f, 0.5f}, 1, 1, {0.5f, 0.5f});
  const Hit hit =
      tracer.intersect({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()}, RayOrder::camera);
  return hit.triangle != kNone ? hit.distance : tracer.scene().radius();
}

bool shows_light(ViewMode mode) { return mode == ViewMode::gather || mode == ViewMode::photons; }

bool needs_photons(ViewMode mode) { return mode != ViewMode::albedo && mode != ViewMode::normal; }

bool needs_diagnosis(ViewMode mode) {
  return mode == ViewMode::density || mode == ViewMode::radius || mode == ViewMode::cost;
}

bool same_picture(const ViewState& a, const ViewState& b) {
  return a.mode == b.mode && a.part == b.part && a.gather == b.gather && a.engine == b.engine && a.kernel == b.kernel &&
         a.photons == b.photons && a.nearest == b.nearest && a.width == b.width && a.height == b.height &&
         a.secondary_gather == b.secondary_gather;
}

const std::vector<std::string>& view_mode_names() {
  static const std::vector<std::string> names = {"gather", "photons", "albedo", "normal", "density", "radius", "cost"};
  return names;
}

const std::vector<std::string>& light_part_names() {
  static const std::vector<std::string> names = {"all", "direct", "indirect", "caustic"};
  return names;
}

}  // namespace glowworm
