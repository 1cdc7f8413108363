// The public header glowworm/scene.h.
#include "glowworm/scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "api/scene_implementation.h"
#include "core/error.h"
#include "import/import.h"

namespace glowworm::api {

namespace {

glowworm::Vec3 inner(Vec3 v) { return {v.x, v.y, v.z}; }
RGB inner(Rgb c) { return {c.r, c.g, c.b}; }

bool is_share(float x) { return x >= 0 && x <= 1; }

void check(bool fine, const std::string& what, const std::string& wanted) {
  if (!fine) throw Error(what, wanted);
}

void check_light(Rgb c, const char* what) {
  for (const float x : {c.r, c.g, c.b})
    check(x >= 0 && std::isfinite(x), std::string("the ") + what + " of a light is negative or not finite",
          "Give three finite numbers of 0 or more.");
}

void check_finite(Vec3 v, const std::string& what) { check(is_finite(inner(v)), what + " is not finite", ""); }

}  // namespace

Scene::Scene(std::shared_ptr<const Implementation> implementation) : implementation_(std::move(implementation)) {}

Scene Scene::load(const std::string& path) { return Scene(std::make_shared<const Implementation>(load_scene(path))); }

const std::string& Scene::name() const { return implementation_->scene->name(); }
std::size_t Scene::triangle_count() const { return implementation_->scene->geometry().triangle_count(); }
const std::vector<std::string>& Scene::notes() const { return implementation_->scene->notes(); }

std::vector<std::string> Scene::cameras() const {
  std::vector<std::string> names;
  for (const glowworm::Camera& camera : implementation_->scene->cameras()) names.push_back(camera.name);
  return names;
}

struct SceneBuilder::Implementation {
  SceneDescription scene;
};

SceneBuilder::SceneBuilder(const std::string& name) : implementation_(std::make_unique<Implementation>()) {
  implementation_->scene.name = name;
}
SceneBuilder::~SceneBuilder() = default;
SceneBuilder::SceneBuilder(SceneBuilder&&) noexcept = default;
SceneBuilder& SceneBuilder::operator=(SceneBuilder&&) noexcept = default;

std::uint32_t SceneBuilder::add_material(const Material& m) {
  check(is_share(m.color.r) && is_share(m.color.g) && is_share(m.color.b) && is_share(m.roughness) &&
            is_share(m.metallic),
        "colour, roughness or metallic of material '" + m.name + "' is out of range", "All must lie in [0, 1].");
  check(m.ior > 0 && std::isfinite(m.ior), "the index of refraction of material '" + m.name + "' is out of range",
        "It must be greater than 0.");
  glowworm::Material out;
  out.name = m.name;
  out.reflectance.value = inner(m.color);
  out.roughness_u.value = out.roughness_v.value = m.roughness;
  out.ior = m.ior;
  switch (m.kind) {
    case Material::Kind::diffuse:
      break;
    case Material::Kind::metal:
      out.kind = MaterialKind::conductor;
      out.use_reflectance = true;
      break;
    case Material::Kind::glass:
      out.kind = MaterialKind::dielectric;
      out.transmittance.value = inner(m.color);
      out.reflectance.value = RGB(1.0f);
      break;
    case Material::Kind::glossy:
      out.kind = MaterialKind::metallic_roughness;
      out.metallic.value = m.metallic;
      out.roughness_u.value = out.roughness_v.value = m.roughness * m.roughness;
      break;
  }
  implementation_->scene.materials.push_back(std::move(out));
  return static_cast<std::uint32_t>(implementation_->scene.materials.size() - 1);
}

void SceneBuilder::add_mesh(const Mesh& mesh) {
  SceneDescription& scene = implementation_->scene;
  check(mesh.material < scene.materials.size(),
        "mesh '" + mesh.name + "' names material " + std::to_string(mesh.material) + " of " +
            std::to_string(scene.materials.size()),
        "Add the material before the mesh.");
  check(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(),
        "mesh '" + mesh.name + "' has " + std::to_string(mesh.normals.size()) + " normals for " +
            std::to_string(mesh.positions.size()) + " vertices",
        "Give one a vertex, or none.");
  check_light(mesh.radiance, "radiance");
  Geometry geometry;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    check_finite(mesh.positions[i], "vertex " + std::to_string(i) + " of mesh '" + mesh.name + "'");
    geometry.positions.push_back(inner(mesh.positions[i]));
    geometry.normals.push_back(mesh.normals.empty() ? glowworm::Vec3{} : inner(mesh.normals[i]));
  }
  geometry.uvs.resize(mesh.positions.size());
  geometry.triangles.assign(mesh.triangles.begin(), mesh.triangles.end());
  std::uint32_t emission = kNone;
  if (mesh.radiance.r > 0 || mesh.radiance.g > 0 || mesh.radiance.b > 0) {
    Emission light;
    light.name = mesh.name;
    light.radiance.value = inner(mesh.radiance);
    emission = static_cast<std::uint32_t>(scene.emissions.size());
    scene.emissions.push_back(std::move(light));
  }
  scene.geometry.begin_object(mesh.name);
  append_mesh(scene.geometry, geometry, mesh.name.c_str(), mesh.material, emission);
}

void SceneBuilder::add_point_light(Vec3 position, Rgb intensity) {
  check_light(intensity, "intensity");
  check_finite(position, "the position of a light");
  Light light;
  light.name = "point light " + std::to_string(implementation_->scene.lights.size() + 1);
  light.intensity = inner(intensity);
  light.position = inner(position);
  implementation_->scene.lights.push_back(std::move(light));
}

void SceneBuilder::add_directional_light(Vec3 direction, Rgb irradiance) {
  check_light(irradiance, "irradiance");
  check_finite(direction, "the direction of a light");
  check(length(inner(direction)) > 0, "the direction of a light has no length", "");
  Light light;
  light.kind = LightKind::directional;
  light.name = "directional light " + std::to_string(implementation_->scene.lights.size() + 1);
  light.intensity = inner(irradiance);
  light.direction = normalize(inner(direction));
  implementation_->scene.lights.push_back(std::move(light));
}

void SceneBuilder::set_environment(Rgb radiance) {
  check_light(radiance, "radiance");
  Environment environment;
  environment.name = "environment";
  environment.scale = inner(radiance);
  implementation_->scene.environment = std::move(environment);
}

void SceneBuilder::add_camera(const Camera& camera) {
  const glowworm::Vec3 axis = inner(camera.target) - inner(camera.eye);
  check(length(cross(axis, inner(camera.up))) > 0, "camera '" + camera.name + "' has no direction",
        "Target and eye must differ, and the way up must not be the way it looks.");
  check(camera.field_of_view > 0 && camera.field_of_view < 180,
        "the field of view of camera '" + camera.name + "' is out of range", "It must lie between 0 and 180 degrees.");
  glowworm::Camera out = look_at(inner(camera.eye), inner(camera.target), inner(camera.up), camera.field_of_view);
  out.name = camera.name;
  implementation_->scene.cameras.push_back(std::move(out));
}

Scene SceneBuilder::build() {
  SceneDescription description = std::exchange(implementation_->scene, SceneDescription());
  return Scene(std::make_shared<const Scene::Implementation>(std::move(description)));
}

}  // namespace glowworm::api
