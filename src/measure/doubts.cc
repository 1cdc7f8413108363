#include "measure/doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/text.h"
#include "scene/default_camera.h"

namespace glowworm {

namespace {

/// Metres: no room is as high, so that its unit is likely another.
constexpr float kHighest = 100;
/// Sensors of which one must see a light.
constexpr std::size_t kSensorsTried = 256;

std::string place_text(Vec3d p) {
  return fmt::format("({}, {}, {})", coordinate_text(p.x), coordinate_text(p.y), coordinate_text(p.z));
}

/// A place of the tables as the user's file has it.
std::string place_text(const Scene& scene, Vec3 p) { return place_text(scene.to_file_axes(scene.outside(p))); }

bool contains(const Box3& box, Vec3 p) {
  const float tolerance = 1e-3f * length(box.diagonal());
  for (int axis = 0; axis < 3; ++axis)
    if (!(p[axis] >= box.min[axis] - tolerance && p[axis] <= box.max[axis] + tolerance)) return false;
  return true;
}

/// A lamp that hangs somewhere.
struct HungLamp {
  std::string name;
  Vec3 place, aim;
};

/// Lights without extent, and luminaires with their openings.
std::vector<HungLamp> hung_lamps(const Scene& scene) {
  std::vector<HungLamp> out;
  for (const Light& light : scene.lights())
    if (light.kind != LightKind::directional && !is_black(light.intensity))
      out.push_back({light.name, light.position, light.kind == LightKind::point ? Vec3{0, -1, 0} : light.direction});
  for (const Emission& emission : scene.emissions()) {
    if (!emission.profile || is_black(emission.radiance.value)) continue;
    Box3 box;
    for (std::uint32_t i = 0; i < emission.triangle_count; ++i)
      for (const std::uint32_t vertex : scene.geometry().triangles[emission.first_triangle + i])
        box.grow(scene.geometry().positions[vertex]);
    out.push_back({emission.name, box.center(), emission.aim});
  }
  return out;
}

/// Whether the first surface along the aim of a lamp shows its back there, as a ceiling below it does.
bool is_behind_surface(const HungLamp& lamp, const Tracer& tracer) {
  const Scene& scene = tracer.scene();
  Ray ray;
  ray.origin = lamp.place;
  ray.direction = lamp.aim;
  ray.t_max = std::numeric_limits<float>::infinity();
  Hit hit = tracer.intersect(ray);
  // The faces of its own opening let the ray pass.
  while (hit.triangle != kNone && scene.is_pane(scene.geometry().material_of(hit.triangle))) {
    ray.t_min = std::nextafter(hit.distance + scene.diffuse_triangle(hit.triangle).offset(), HUGE_VALF);
    hit = tracer.intersect(ray);
  }
  return hit.triangle != kNone && dot(scene.geometry().normal(hit.triangle), ray.direction) > 0;
}

/// Whether one of the sensors, of many some, sees a place, perhaps through panes.
bool is_seen(Vec3 place, const Sensors& sensors, const Tracer& tracer) {
  const std::size_t step = (sensors.size() + kSensorsTried - 1) / kSensorsTried;
  for (std::size_t i = 0; i < sensors.size(); i += step) {
    const Vec3 way = place - sensors.position[i];
    const float distance = length(way);
    Ray ray;
    ray.origin = sensors.position[i];
    ray.direction = way / distance;
    ray.t_max = distance * (1 - 1e-4f);
    ray.t_min = distance * 1e-4f;
    if (!(distance > 0) || !is_black(tracer.transmittance(ray))) return true;
  }
  return false;
}

/// The largest share of samples that may bring light, with a chance of 95%, where none of so many independent ones did:
/// 3 / samples of many (Hanley and Lippman-Hand, "If Nothing Goes Wrong, Is Everything All Right?", JAMA 249, 1983).
double share_unseen(std::uint32_t samples) {
  constexpr double kChance = 0.95;
  return 1 - std::pow(1 - kChance, 1.0 / std::max(samples, 1u));
}

std::optional<std::string> doubt_of_sensors(const Sensors& sensors, const Scene& scene) {
  std::size_t count = 0, first = 0;
  for (std::size_t i = sensors.size(); i-- > 0;)
    if (!contains(scene.bounds(), sensors.position[i])) ++count, first = i;
  if (count == 0) return std::nullopt;
  return fmt::format("{} of {} sensors are outside of the room, the first of them at {}", count, sensors.size(),
                     place_text(scene, sensors.position[first]));
}

}  // namespace

std::shared_ptr<const Scene> lit_by_its_own(const std::shared_ptr<const Scene>& scene) {
  if (!scene->environment() || !scene->environment()->stands_in) return scene;
  return std::make_shared<const Scene>(
      *scene, SceneEdit{scene->emissions(), scene->lights(), std::nullopt, scene->shared_geometry(), {}, ""});
}

std::vector<std::string> doubts_before(const Sensors& sensors, const Tracer& tracer) {
  const Scene& scene = tracer.scene();
  std::vector<std::string> out;
  if (!(scene.light_power().total() > 0)) out.push_back("the scene has no light: all sensors measure 0");
  const bool is_room = shape_of(scene.geometry()) == SceneShape::room;
  if (const Vec3 size = scene.bounds().diagonal(); is_room && std::min({size.x, size.y, size.z}) > kHighest)
    out.push_back(
        fmt::format("the room is {:.0f} x {:.0f} x {:.0f} m large; is its unit the metre?", size.x, size.y, size.z));
  if (is_room)
    if (const auto doubt = doubt_of_sensors(sensors, scene)) out.push_back(*doubt);
  for (const HungLamp& lamp : hung_lamps(scene)) {
    const bool is_outside = is_room && !contains(scene.bounds(), lamp.place);
    if (!(is_outside || is_behind_surface(lamp, tracer)) || is_seen(lamp.place, sensors, tracer)) continue;
    out.push_back(fmt::format("no sensor sees the light \"{}\" at {}, which hangs {}", lamp.name,
                              place_text(scene, lamp.place),
                              is_outside ? "outside of the room" : "behind a surface, such as a ceiling"));
  }
  return out;
}

std::vector<std::string> doubts_after(const Measurement& measured, const Scene& scene) {
  const auto is_dark = [](RGB e) { return is_black(e); };
  const std::vector<RGB>& e = measured.irradiance;
  const auto count = std::count_if(e.begin(), e.end(), is_dark);
  if (count == 0 || !(scene.light_power().total() > 0)) return {};
  const auto first = static_cast<std::size_t>(std::find_if(e.begin(), e.end(), is_dark) - e.begin());
  return {fmt::format(
      "{} of {} sensors measured no light at all, the first of them at {}: they may lie outside of the "
      "room or inside of a solid. Otherwise {} samples were too few: with 95% confidence, at most {:.2g}% of samples "
      "find light there. The relative error of these sensors is unknown",
      count, e.size(), place_text(measured.place(first)), measured.samples, 100 * share_unseen(measured.samples))};
}

}  // namespace glowworm
