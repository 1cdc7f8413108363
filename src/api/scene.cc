// The public header glowworm/scene.h.
#include "glowworm/scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "api/scene_implementation.h"
#include "builtin/builtin.h"
#include "core/error.h"
#include "core/names.h"
#include "import/gltf/parts.h"
#include "import/import.h"
#include "import/instance_keeper.h"
#include "import/mesh_tools.h"
#include "import/scene_changes.h"
#include "import/texture_cache.h"
#include "scene/light_rig.h"
#include "scene/scene_checks.h"

namespace glowworm::api {

namespace {

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

template <typename T>
std::vector<std::string> names_of(const std::vector<T>& things) {
  std::vector<std::string> names;
  for (const T& thing : things) names.push_back(thing.name);
  return names;
}

}  // namespace

glowworm::Camera inner(const Camera& camera) {
  const std::string name = "camera '" + camera.name + "'";
  for (const Vec3& v : {camera.eye, camera.target, camera.up}) check_finite(v, "the place of " + name);
  const glowworm::Vec3 axis = inner(camera.target) - inner(camera.eye);
  check(length(cross(axis, inner(camera.up))) > 0, name + " has no direction",
        "Target and eye must differ, and the way up must not be the way it looks.");
  using Projection = Camera::Projection;
  check(camera.projection <= Projection::panorama, name + " has no projection", "Give one of Camera::Projection.");
  const bool is_fisheye = camera.projection == Projection::fisheye, divides = camera.projection == Projection{};
  check(camera.field_of_view > 0 && camera.field_of_view <= (is_fisheye ? 360.0f : 180.0f) &&
            (!divides || camera.field_of_view < 180),
        "the field of view of " + name + " is out of range",
        is_fisheye ? "It must lie between 0 and 360 degrees." : "It must lie between 0 and 180 degrees.");
  const auto is_length = [](float x) { return x >= 0 && std::isfinite(x); };
  check(is_length(camera.orthographic_size) && is_length(camera.lens_radius) && is_length(camera.focal_distance),
        "the size or the lens of " + name + " is negative or not finite", "Give metres, 0 or more.");
  glowworm::Camera out = look_at(inner(camera.eye), inner(camera.target), inner(camera.up), camera.field_of_view);
  if (!divides) {
    constexpr CameraKind kKinds[] = {CameraKind::perspective, CameraKind::fisheye, CameraKind::hemispherical,
                                     CameraKind::panorama};
    out.kind = kKinds[static_cast<std::size_t>(camera.projection)];
    out.half_extent = half_extent_of(out.kind, camera.field_of_view);
  } else if (camera.orthographic_size > 0) {
    out.kind = CameraKind::orthographic;
    out.half_extent = camera.orthographic_size / 2;
  }
  out.lens_radius = camera.lens_radius;
  out.focal_distance = camera.focal_distance > 0 ? camera.focal_distance : length(axis);
  out.name = camera.name;
  return out;
}

Scene::Scene(std::shared_ptr<const Implementation> implementation) : implementation_(std::move(implementation)) {}

std::vector<std::string> load_option_names() {
  std::vector<std::string> names;
  for (const SceneOption& option : scene_options()) names.push_back(std::string(option.name).substr(2));
  return names;
}

Scene Scene::load(const std::string& path, const LoadOptions& options) {
  SceneChanges changes;
  if (options.z_up) changes.z_up = true;  // else as the format has it
  check(options.scale > 0 && std::isfinite(options.scale), "the scale of a scene must be a finite number above 0",
        "Give metres per unit of the file.");
  changes.metres_per_unit = options.scale;
  if (!options.environment.empty()) parse_environment(options.environment, changes);
  changes.sky = options.sky;
  changes.studio_light = options.studio_light;
  const std::vector<std::string> names = load_option_names();
  for (const auto& [name, text] : options.more)
    scene_options()[name_index("scene option", name, names)].read(changes, text);
  ImportOptions reading;
  reading.moment = changes.moment;
  reading.light_uvs = true;  // this and the next for bake()
  reading.gltf_parts = std::make_shared<GltfParts>();
  reading.outside_files = std::make_shared<std::vector<std::string>>();
  SceneDescription description = load_scene(path, reading);
  const std::size_t own = description.geometry.triangles.size();
  change_scene(description, changes, reading.budget);
  // Triangles that were added, as of luminous openings, come before instances.
  if (!description.geometry.instances.empty())
    for (GltfPart& part : reading.gltf_parts->parts)
      if (part.first_triangle >= own)
        part.first_triangle += static_cast<std::uint32_t>(description.geometry.triangles.size() - own);
  return Scene(
      std::make_shared<const Implementation>(std::move(description), reading.gltf_parts, *reading.outside_files));
}

std::vector<std::string> Scene::lights() const { return names_of(LightRig(implementation_->scene).lights()); }

Scene Scene::with_lights(std::span<const LightEdit> edits) const {
  const LightRig rig(implementation_->scene);
  std::vector<glowworm::LightEdit> all(rig.lights().size());
  for (const LightEdit& edit : edits) {
    const std::string name = "the light '" + edit.light + "'";
    check(edit.scale >= 0 && std::isfinite(edit.scale), "the scale of " + name + " is negative or not finite", "");
    check_finite(edit.move, "the move of " + name);
    check_finite(edit.turn, "the turn of " + name);
    all[name_index("the light", edit.light, lights())] = {edit.on, edit.scale, inner(edit.move), inner(edit.turn)};
  }
  return Scene(std::make_shared<const Implementation>(rig.edited(all), implementation_->gltf_parts,
                                                      implementation_->outside_files));
}

const std::string& Scene::name() const { return implementation_->scene->name(); }
std::size_t Scene::triangle_count() const { return implementation_->scene->geometry().triangle_count(); }
const std::vector<std::string>& Scene::notes() const { return implementation_->scene->notes(); }

std::vector<std::string> Scene::cameras() const { return names_of(implementation_->scene->cameras()); }

std::vector<std::string> Scene::materials() const { return names_of(implementation_->scene->materials()); }

std::span<const Vec3> Scene::positions() const {
  static_assert(sizeof(Vec3) == sizeof(glowworm::Vec3));
  const std::vector<glowworm::Vec3>& positions = implementation_->geometry().positions;
  return {reinterpret_cast<const Vec3*>(positions.data()), positions.size()};
}

std::span<const Triangle> Scene::triangles() const { return implementation_->geometry().triangles; }

std::span<const std::uint32_t> Scene::triangle_materials() const { return implementation_->geometry().material; }

Scene Scene::with_camera(const Camera& camera) const { return with_cameras(std::span(&camera, 1)); }

Scene Scene::with_cameras(std::span<const Camera> more) const {
  const glowworm::Scene& scene = *implementation_->scene;
  const std::vector<std::string> before = cameras();
  std::set<std::string> names(before.begin(), before.end());
  SceneEdit edit{scene.emissions(), scene.lights(), scene.environment(), scene.shared_geometry(), {}, ""};
  for (const Camera& camera : more) {
    check(names.insert(camera.name).second, "the scene has a camera '" + camera.name + "' already",
          "Give the new one another name.");
    edit.more_cameras.push_back(inner(camera));
    glowworm::Vec3& place = edit.more_cameras.back().to_world.translation;
    place = scene.inside(place);
  }
  return Scene(std::make_shared<const Implementation>(*implementation_, std::move(edit)));
}

std::vector<std::string> builtin_scenes() { return builtin_scene_names(); }

namespace {

void check_pixels(int width, int height, std::size_t pixels, const char* image) {
  check(width > 0 && height > 0 && pixels == static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
        std::string("the image of ") + image + " has " + std::to_string(pixels) + " pixels, not " +
            std::to_string(width) + " x " + std::to_string(height),
        "");
}

}  // namespace

struct SceneBuilder::Implementation {
  SceneDescription scene;

  /// Checks a mesh, and copies its arrays.
  Geometry copy_of(const Mesh& mesh) const;
  /// The index of a mesh's emission, which is added, or kNone.
  std::uint32_t add_emission(const Mesh& mesh);
  /// Adds a light with the number of its name.
  Light& add_light(LightKind kind, const std::string& name, Rgb intensity);
  /// Adds an environment without pixels.
  Environment& add_environment();
};

SceneBuilder::SceneBuilder(const std::string& name) : implementation_(std::make_unique<Implementation>()) {
  implementation_->scene.name = name;
}
SceneBuilder::~SceneBuilder() = default;
SceneBuilder::SceneBuilder(SceneBuilder&&) noexcept = default;
SceneBuilder& SceneBuilder::operator=(SceneBuilder&&) noexcept = default;

std::uint32_t SceneBuilder::add_texture(int width, int height, std::span<const Rgb> pixels) {
  check_pixels(width, height, pixels.size(), "a texture");
  for (const Rgb& c : pixels)
    check(is_share(c.r) && is_share(c.g) && is_share(c.b), "a pixel of a texture is out of range",
          "All must lie in [0, 1].");
  TextureNode node;
  node.kind = TextureKind::image;
  ImageFileData image;
  image.header.width = width;
  image.header.height = height;
  image.header.channels = 3;
  const auto bytes = std::as_bytes(pixels);
  image.samples.assign(bytes.begin(), bytes.end());
  node.image = texture_image(make_texture(std::make_shared<const ImageFileData>(std::move(image)), {}));
  implementation_->scene.textures.push_back(std::move(node));
  return static_cast<std::uint32_t>(implementation_->scene.textures.size() - 1);
}

namespace {

std::vector<RGB> inner(std::span<const Rgb> colors) {
  std::vector<RGB> out;
  for (const Rgb& color : colors) out.push_back(inner(color));
  return out;
}

/// Checks an index among `count` things of a kind. @param owner names it
std::uint32_t known(std::uint32_t index, std::size_t count, const std::string& owner, const std::string& kind) {
  check(index < count, owner + " names " + kind + " " + std::to_string(index) + " of " + std::to_string(count),
        "Add the " + kind + " before.");
  return index;
}

std::uint32_t known_medium(std::uint32_t medium, std::size_t media, const std::string& owner) {
  return medium == kVacuum ? medium : known(medium, media, owner, "medium");
}

/// Checks that a mesh has `count` values for its vertices, or none.
void check_values(const Mesh& mesh, std::size_t count, const std::string& values) {
  check(count == 0 || count == mesh.positions.size(),
        "mesh '" + mesh.name + "' has " + std::to_string(count) + " " + values + " for " +
            std::to_string(mesh.positions.size()) + " vertices",
        "Give one a vertex, or none.");
}

}  // namespace

std::uint32_t SceneBuilder::add_medium(const Medium& m) {
  static_assert(kVacuum == kNone);
  const std::string what = "medium '" + m.name + "'";
  glowworm::Medium out;
  out.name = m.name;
  out.sigma_a = inner(m.absorption);
  out.sigma_s = inner(m.scattering);
  out.g = m.mean_cosine;
  out.emission = inner(m.emission);
  if (m.box) {
    check_finite(m.box->first, "a corner of " + what);
    check_finite(m.box->second, "a corner of " + what);
    out.bounds.emplace().grow(inner(m.box->first));
    out.bounds->grow(inner(m.box->second));
  }
  if (m.cells != std::array<int, 3>{0, 0, 0}) {
    check(m.box.has_value(), what + " has a grid without a box", "Give the box that the cells divide.");
    out.grid = std::make_shared<const MediumGrid>(MediumGridValues{m.cells,
                                                                   {m.density_grid.begin(), m.density_grid.end()},
                                                                   inner(m.absorption_grid),
                                                                   inner(m.scattering_grid),
                                                                   inner(m.emission_grid)});
  }
  check_medium(out, 0);
  implementation_->scene.media.push_back(std::move(out));
  return static_cast<std::uint32_t>(implementation_->scene.media.size() - 1);
}

void SceneBuilder::set_ambient_medium(std::uint32_t medium) {
  SceneDescription& scene = implementation_->scene;
  scene.ambient_medium = known_medium(medium, scene.media.size(), "the space of the scene");
}

std::uint32_t SceneBuilder::add_material(const Material& m) {
  check(is_share(m.color.r) && is_share(m.color.g) && is_share(m.color.b) && is_share(m.roughness) &&
            is_share(m.metallic),
        "colour, roughness or metallic of material '" + m.name + "' is out of range", "All must lie in [0, 1].");
  check(m.ior > 0 && std::isfinite(m.ior), "the index of refraction of material '" + m.name + "' is out of range",
        "It must be greater than 0.");
  glowworm::Material out;
  out.name = m.name;
  out.reflectance.value = inner(m.color);
  if (m.color_texture)
    out.reflectance.texture =
        known(*m.color_texture, implementation_->scene.textures.size(), "material '" + m.name + "'", "texture");
  out.roughness_u.value = out.roughness_v.value = m.roughness;
  out.ior = m.ior;
  out.unseen = m.unseen;
  const std::size_t media = implementation_->scene.media.size();
  if (m.inside) out.inside = known_medium(*m.inside, media, "material '" + m.name + "'");
  if (m.outside) out.outside = known_medium(*m.outside, media, "material '" + m.name + "'");
  switch (m.kind) {
    case Material::Kind::diffuse:
      break;
    case Material::Kind::metal:
      out.kind = MaterialKind::conductor;
      out.use_reflectance = true;
      break;
    case Material::Kind::glass:
      out.kind = MaterialKind::dielectric;
      out.transmittance = std::exchange(out.reflectance, {});
      break;
    case Material::Kind::glossy:
      out.kind = MaterialKind::metallic_roughness;
      out.metallic.value = m.metallic;
      out.roughness_u.value = out.roughness_v.value = m.roughness * m.roughness;
      break;
    case Material::Kind::pane:
      out.kind = MaterialKind::thin_dielectric;
      out.transmittance = std::exchange(out.reflectance, {});
      break;
    case Material::Kind::plastic:
      out.kind = MaterialKind::coated_diffuse;
      out.coat_thickness = 0;
      out.coat_bounces = 0;  // unlimited
      break;
    case Material::Kind::interface:
      out.kind = MaterialKind::interface;
      break;
    default:  // a program may cast any number
      check(false, "material '" + m.name + "' is of no kind", "Give one of Material::Kind.");
  }
  implementation_->scene.materials.push_back(std::move(out));
  return static_cast<std::uint32_t>(implementation_->scene.materials.size() - 1);
}

Geometry SceneBuilder::Implementation::copy_of(const Mesh& mesh) const {
  known(mesh.material, scene.materials.size(), "mesh '" + mesh.name + "'", "material");
  check_values(mesh, mesh.normals.size(), "normals");
  check_values(mesh, mesh.uvs.size(), "texture coordinates");
  check_light(mesh.radiance, "radiance");
  Geometry geometry;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    check_finite(mesh.positions[i], "vertex " + std::to_string(i) + " of mesh '" + mesh.name + "'");
    if (!mesh.normals.empty())
      check_finite(mesh.normals[i], "normal " + std::to_string(i) + " of mesh '" + mesh.name + "'");
    geometry.positions.push_back(inner(mesh.positions[i]));
    geometry.normals.push_back(mesh.normals.empty() ? glowworm::Vec3{} : inner(mesh.normals[i]));
  }
  for (const Vec2& uv : mesh.uvs) {
    check(std::isfinite(uv.x) && std::isfinite(uv.y), "a texture coordinate of mesh '" + mesh.name + "' is not finite",
          "");
    geometry.uvs.push_back({uv.x, uv.y});
  }
  geometry.uvs.resize(mesh.positions.size());
  geometry.triangles.assign(mesh.triangles.begin(), mesh.triangles.end());
  return geometry;
}

std::uint32_t SceneBuilder::Implementation::add_emission(const Mesh& mesh) {
  if (!(mesh.radiance.r > 0 || mesh.radiance.g > 0 || mesh.radiance.b > 0)) return kNone;
  Emission light;
  light.name = mesh.name;
  light.radiance.value = inner(mesh.radiance);
  light.two_sided = mesh.two_sided;
  scene.emissions.push_back(std::move(light));
  return static_cast<std::uint32_t>(scene.emissions.size() - 1);
}

Light& SceneBuilder::Implementation::add_light(LightKind kind, const std::string& name, Rgb intensity) {
  Light& light = scene.lights.emplace_back();
  light.kind = kind;
  light.name = name + " " + std::to_string(scene.lights.size());
  light.intensity = inner(intensity);
  return light;
}

Environment& SceneBuilder::Implementation::add_environment() {
  Environment& environment = scene.environment.emplace();
  environment.name = "environment";
  return environment;
}

void SceneBuilder::add_mesh(const Mesh& mesh) {
  const Geometry geometry = implementation_->copy_of(mesh);
  const std::uint32_t emission = implementation_->add_emission(mesh);
  Geometry& all = implementation_->scene.geometry;
  all.begin_object(mesh.name);
  append_mesh(all, geometry, mesh.name.c_str(), mesh.material, emission);
}

void SceneBuilder::add_instances(const Mesh& mesh, std::span<const Placement> places) {
  const Geometry geometry = implementation_->copy_of(mesh);
  const std::uint32_t emission = implementation_->add_emission(mesh);
  Geometry& all = implementation_->scene.geometry;
  MemoryBudget unlimited;
  Reservation held(unlimited, "triangles", 0);
  CoordinateOrigin origin;
  InstanceKeeper keeper(all, origin, held);
  const auto make = [&] {
    SharedMesh shared;
    append_mesh(shared.geometry, geometry, mesh.name.c_str(), mesh.material, kNone);
    return shared;
  };
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::string name = mesh.name + " " + std::to_string(i + 1);
    const auto column = [&](std::size_t c) { return Vec3d{places[i][0][c], places[i][1][c], places[i][2][c]}; };
    const TransformDouble to_world{column(0), column(1), column(2), column(3)};
    check(is_finite(to_world.x) && is_finite(to_world.y) && is_finite(to_world.z) && is_finite(to_world.translation),
          "the place of " + name + " is not finite", "");
    if (emission == kNone && keeper.keep(&mesh, to_world, name, make) != kNone) continue;
    Geometry copy = geometry;
    place_mesh(copy, to_world, origin);
    all.begin_object(name);
    append_mesh(all, copy, name.c_str(), mesh.material, emission);
  }
}

void SceneBuilder::add_point_light(Vec3 position, Rgb intensity) {
  check_light(intensity, "intensity");
  check_finite(position, "the position of a light");
  implementation_->add_light(LightKind::point, "point light", intensity).position = inner(position);
}

void SceneBuilder::add_directional_light(Vec3 direction, Rgb irradiance) {
  check_light(irradiance, "irradiance");
  check_finite(direction, "the direction of a light");
  check(length(inner(direction)) > 0, "the direction of a light has no length", "");
  implementation_->add_light(LightKind::directional, "directional light", irradiance).direction =
      normalize(inner(direction));
}

void SceneBuilder::add_spot_light(const SpotLight& spot) {
  check_light(spot.intensity, "intensity");
  check_finite(spot.position, "the position of a light");
  check_finite(spot.direction, "the direction of a light");
  check(length(inner(spot.direction)) > 0, "the direction of a light has no length", "");
  check(spot.inner_angle >= 0 && spot.inner_angle <= spot.outer_angle && spot.outer_angle > 0 && spot.outer_angle <= 90,
        "the angles of a spot light are out of range",
        "The inner one must lie between 0 and the outer one, and the outer one between 0 and 90 degrees.");
  Light& light = implementation_->add_light(LightKind::spot, "spot light", spot.intensity);
  light.position = inner(spot.position);
  light.direction = normalize(inner(spot.direction));
  light.cos_inner = std::cos(spot.inner_angle * (kPi / 180));
  light.cos_outer = std::cos(spot.outer_angle * (kPi / 180));
}

void SceneBuilder::set_environment(int width, int height, std::span<const Rgb> pixels) {
  check_pixels(width, height, pixels.size(), "the environment");
  for (const Rgb& pixel : pixels) check_light(pixel, "radiance");
  Environment& environment = implementation_->add_environment();
  environment.width = width;
  environment.height = height;
  environment.pixels = inner(pixels);
}

void SceneBuilder::set_environment(Rgb radiance) {
  check_light(radiance, "radiance");
  implementation_->add_environment().scale = inner(radiance);
}

void SceneBuilder::add_camera(const Camera& camera) { implementation_->scene.cameras.push_back(inner(camera)); }

Scene SceneBuilder::build() {
  SceneDescription description = std::exchange(implementation_->scene, SceneDescription());
  description.geometry.number_instances();
  return Scene(std::make_shared<const Scene::Implementation>(std::move(description)));
}

}  // namespace glowworm::api
