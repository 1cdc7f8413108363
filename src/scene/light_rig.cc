#include "scene/light_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/error.h"
#include "core/frame.h"
#include "core/names.h"
#include "scene/light_sampling.h"

namespace glowworm {

namespace {

bool moves(const LightEdit& edit) { return length_squared(edit.move) > 0 || length_squared(edit.turn) > 0; }

RigLightKind rig_kind(LightKind kind) {
  return kind == LightKind::point                                  ? RigLightKind::point
         : kind == LightKind::spot || kind == LightKind::luminaire ? RigLightKind::spot
                                                                   : RigLightKind::directional;
}

/// Emissions in the order of their first triangle, those that are black now, too: they count where names repeat.
std::vector<RigLight> area_lights(const Scene& scene) {
  const Geometry& g = scene.geometry();
  std::vector<RigLight> lights;
  std::map<std::uint32_t, std::size_t> place;
  for (std::uint32_t triangle = 0; triangle < g.emission.size(); ++triangle) {
    if (g.emission[triangle] == kNone || !place.try_emplace(g.emission[triangle], lights.size()).second) continue;
    RigLight& light = lights.emplace_back();
    light.index = g.emission[triangle];
    light.name = scene.emissions()[light.index].name;
    if (light.name.empty()) light.name = "area light";
  }
  for (const std::uint32_t triangle : scene.emissive_triangles())
    lights[place.at(g.emission[triangle])].triangles.push_back(triangle);
  for (RigLight& light : lights) {
    Box3 box;
    for (const std::uint32_t triangle : light.triangles)
      for (const std::uint32_t vertex : g.triangles[triangle]) box.grow(g.positions[vertex]);
    light.center = box.center();
  }
  return lights;
}

std::vector<std::string> names_of(const std::vector<RigLight>& lights) {
  std::vector<std::string> names;
  for (const RigLight& light : lights) names.push_back(light.name);
  return names;
}

}  // namespace

LightRig::LightRig(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)), lights_(area_lights(*scene_)) {
  const auto first = static_cast<std::uint32_t>(scene_->emissive_triangles().size());
  for (std::uint32_t i = 0; i < scene_->lights().size(); ++i) {
    const Light& light = scene_->lights()[i];
    lights_.push_back({light_source_name(*scene_, first + i),
                       rig_kind(light.kind),
                       i,
                       light.position,
                       light.kind == LightKind::point ? Vec3{0, 0, 0} : light.direction,
                       {}});
  }
  if (scene_->environment()) {
    lights_.push_back(
        {light_source_name(*scene_, scene_->first_environment_source()), RigLightKind::environment, 0, {}, {}, {}});
  }
  std::vector<std::string> names = names_of(lights_);
  number_repeated(names);
  for (std::size_t i = 0; i < lights_.size(); ++i) lights_[i].name = names[i];
  std::erase_if(lights_, [](const RigLight& l) { return l.kind == RigLightKind::area && l.triangles.empty(); });
}

std::size_t LightRig::find(const std::string& name) const {
  for (std::size_t i = 0; i < lights_.size(); ++i)
    if (std::to_string(i) == name) return i;
  return name_index("the light", name, names_of(lights_));
}

std::vector<std::uint32_t> LightRig::movable_triangles() const {
  std::vector<std::uint32_t> all;
  for (const RigLight& light : lights_) all.insert(all.end(), light.triangles.begin(), light.triangles.end());
  return all;
}

void LightRig::check_count(const std::vector<LightEdit>& edits) const {
  if (edits.size() != lights_.size())
    throw Error(fmt::format("{} lights were to be edited, but the scene has {}", edits.size(), lights_.size()));
}

std::vector<LightEdit> LightRig::edits_of(const LightRig& other, const std::vector<LightEdit>& edits) const {
  if (edits.empty()) return {};
  other.check_count(edits);
  std::map<std::string, LightEdit> named;
  for (std::size_t i = 0; i < edits.size(); ++i) named[other.lights_[i].name] = edits[i];
  std::vector<LightEdit> out;
  for (const RigLight& light : lights_) out.push_back(named[light.name]);
  return out;
}

bool LightRig::same_geometry(const std::vector<LightEdit>& a, const std::vector<LightEdit>& b) const {
  const LightEdit none;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    if (lights_[i].kind != RigLightKind::area) continue;
    const LightEdit &x = i < a.size() ? a[i] : none, &y = i < b.size() ? b[i] : none;
    if (!(x.move == y.move) || !(x.turn == y.turn)) return false;
  }
  return true;
}

std::shared_ptr<const Geometry> LightRig::moved_geometry(const std::vector<LightEdit>& edits) const {
  if (same_geometry(edits, {})) return nullptr;
  auto geometry = std::make_shared<Geometry>(scene_->geometry());
  for (std::size_t i = 0; i < edits.size(); ++i) {
    if (lights_[i].kind != RigLightKind::area || !moves(edits[i])) continue;
    const Vec3 center = lights_[i].center, to = center + edits[i].move;
    for (const std::uint32_t triangle : lights_[i].triangles)
      for (std::uint32_t& vertex : geometry->triangles[triangle]) {
        // Their own vertices, so that neighbouring triangles that do not emit stay in place.
        geometry->positions.push_back(to + rotate(geometry->positions[vertex] - center, edits[i].turn));
        geometry->normals.push_back(rotate(geometry->normals[vertex], edits[i].turn));
        geometry->uvs.push_back(geometry->uvs[vertex]);
        if (!geometry->second_uvs.empty()) geometry->second_uvs.push_back(geometry->second_uvs[vertex]);
        if (!geometry->colors.empty()) geometry->colors.push_back(geometry->colors[vertex]);
        vertex = static_cast<std::uint32_t>(geometry->positions.size() - 1);
      }
  }
  return geometry;
}

std::shared_ptr<const Scene> LightRig::edited(const std::vector<LightEdit>& edits) const {
  if (edits.empty()) return scene_;
  check_count(edits);
  if (std::all_of(edits.begin(), edits.end(), [](const LightEdit& e) { return e == LightEdit(); })) return scene_;
  SceneEdit tables{scene_->emissions(), scene_->lights(), scene_->environment(), moved_geometry(edits), {}, {}};
  for (std::size_t i = 0; i < edits.size(); ++i) {
    const LightEdit& edit = edits[i];
    const float factor = edit.on ? std::max(edit.scale, 0.0f) : 0.0f;
    if (lights_[i].kind == RigLightKind::area) {
      Emission& emission = tables.emissions[lights_[i].index];
      emission.radiance.value *= factor;
      emission.aim = rotate(emission.aim, edit.turn);
      emission.right = rotate(emission.right, edit.turn);
    } else if (lights_[i].kind == RigLightKind::environment) {
      Environment& sky = *tables.environment;
      sky.scale *= factor;
      Transform& m = sky.to_world;
      m = {rotate(m.x, edit.turn), rotate(m.y, edit.turn), rotate(m.z, edit.turn), m.translation};
    } else {
      Light& light = tables.lights[lights_[i].index];
      light.intensity *= factor;
      light.position += edit.move;
      light.direction = rotate(light.direction, edit.turn);
      light.right = rotate(light.right, edit.turn);
    }
  }
  return std::make_shared<const Scene>(*scene_, std::move(tables));
}

SunAngles sun_angles(Vec3 direction, Vec3 up) {
  const Frame frame = Frame::from_normal(up);
  const Vec3 to_sun = frame.to_local(-direction);
  return {std::atan2(to_sun.y, to_sun.x), std::asin(std::clamp(to_sun.z, -1.0f, 1.0f))};
}

Vec3 sun_direction(SunAngles angles, Vec3 up) {
  const float c = std::cos(angles.elevation);
  return -Frame::from_normal(up).to_world(
      {c * std::cos(angles.azimuth), c * std::sin(angles.azimuth), std::sin(angles.elevation)});
}

Vec3 rotation_between(Vec3 from, Vec3 to) {
  const Vec3 axis = cross(from, to);
  const float sine = length(axis), angle = std::atan2(sine, dot(from, to));
  if (sine > 0) return axis * (angle / sine);
  return angle > 1 ? Frame::from_normal(from).s * angle : Vec3{0, 0, 0};
}

}  // namespace glowworm
