#include "import/scene_changes.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "core/error.h"
#include "core/input_file.h"
#include "core/text.h"
#include "image/image_file.h"
#include "image/texture_file.h"
#include "import/haze.h"
#include "import/ies/luminaire.h"
#include "import/ies/luminous_opening.h"
#include "import/material_text.h"
#include "import/mesh_tools.h"
#include "import/sky_text.h"
#include "import/volume_text.h"
#include "scene/default_camera.h"
#include "scene/environment_bytes.h"
#include "scene/radiance_view.h"
#include "scene/scene_checks.h"

namespace glowworm {

namespace {

/// Parses a radiance; empty if the text is not made of numbers.
std::optional<RGB> parse_radiance(const std::string& text) {
  const std::vector<float> v = numbers_of<float>(text);
  if (v.size() == 1) return RGB(v[0]);
  return v.size() == 3 ? std::optional(RGB(v[0], v[1], v[2])) : std::nullopt;
}

/// Rotates the axis that points up to y and scales lengths and coefficients of media, which are per metre. Intensities,
/// fluxes and radiances are unchanged.
void change_space(SceneDescription& d, bool z_up, float scale) {
  Transform turn;
  if (z_up && !d.z_up) turn = {turn.x, y_up_from_z_up(turn.y), y_up_from_z_up(turn.z), {0, 0, 0}};
  if (!z_up && d.z_up) turn = {turn.x, z_up_from_y_up(turn.y), z_up_from_y_up(turn.z), {0, 0, 0}};
  d.z_up = z_up;
  Transform map = {turn.x * scale, turn.y * scale, turn.z * scale, {0, 0, 0}};
  // The new origin is rounded to floats; positions take up the difference.
  const Vec3d origin = TransformDouble{Vec3d(map.x), Vec3d(map.y), Vec3d(map.z), {}}.point(Vec3d(d.origin));
  d.origin = narrow(origin);
  map.translation = narrow(origin - Vec3d(d.origin));
  transform_mesh(d.geometry, map);
  for (Material& material : d.materials) {
    material.bump.value *= scale;
    material.measured_up = turn.vector(material.measured_up);
  }
  for (Medium& medium : d.media) {
    medium.sigma_a *= 1 / scale;
    medium.sigma_s *= 1 / scale;
    medium.to_medium = medium.to_medium * inverse(map);
  }
  for (Light& light : d.lights) {
    light.position = map.point(light.position);
    light.direction = turn.vector(light.direction);
    light.right = turn.vector(light.right);
  }
  if (d.environment) d.environment->to_world = turn * d.environment->to_world;
  for (Camera& camera : d.cameras) {
    const Vec3 place = map.point(camera.to_world.translation);
    camera.to_world = turn * camera.to_world;
    camera.to_world.translation = place;
    camera.lens_radius *= scale;
    camera.focal_distance *= scale;
    if (camera.kind == CameraKind::orthographic) camera.half_extent *= scale;
  }
}

/// Degrees along the shorter side.
constexpr float kDefaultFieldOfView = 45, kAngularFieldOfView = 180;

/// Gives a camera the projection and the field of view of the changes.
void change_camera(Camera& camera, const SceneChanges& changes) {
  float degrees = changes.field_of_view;
  if (changes.projection && camera.kind != *changes.projection) {
    camera.kind = *changes.projection;
    camera.aspect = 0;
    if (degrees <= 0) degrees = is_angular(camera.kind) ? kAngularFieldOfView : kDefaultFieldOfView;
  }
  if (degrees <= 0 || camera.kind == CameraKind::orthographic) return;
  const float most = camera.kind == CameraKind::fisheye ? 360 : is_angular(camera.kind) ? 180 : 175;
  if (degrees > most)
    throw Error(fmt::format("--fov {:g} is more than the {:g} degrees that this projection shows", degrees, most));
  camera.half_extent = half_extent_of(camera.kind, degrees);
}

void add_views(SceneDescription& d, const std::string& path, MemoryBudget& budget) {
  Reservation held(budget, "the file of views", 0);
  std::vector<Camera> cameras;
  for (const RadianceView& view : parse_radiance_views(read_input_file(path, held), path)) {
    cameras.push_back(camera_of(view, d.z_up, d.origin));
    cameras.back().name = fmt::format("view {}", cameras.size());
  }
  d.cameras.insert(d.cameras.begin(), cameras.begin(), cameras.end());
}

void change_cameras(SceneDescription& d, const SceneChanges& changes) {
  if (changes.look_at) {
    Camera first = d.cameras.empty() ? Camera() : d.cameras.front();
    const auto inside = [&](Vec3d place) { return narrow((d.z_up ? y_up_from_z_up(place) : place) - Vec3d(d.origin)); };
    const Vec3 eye = inside((*changes.look_at)[0]), target = inside((*changes.look_at)[1]);
    // If the camera looks straight up or down, the scene's -z is at the upper edge of the picture.
    const Vec3 way = target - eye;
    const Vec3 up = length(cross(way, {0, 1, 0})) > 1e-4f * length(way) ? Vec3{0, 1, 0} : Vec3{0, 0, -1};
    first.to_world = look_at(eye, target, up, 45).to_world;
    if (d.cameras.empty()) {
      d.cameras.push_back(look_at(eye, target, up, 45));
    } else {
      d.cameras.front() = std::move(first);
    }
    if (d.cameras.front().name.empty()) d.cameras.front().name = "look-at";
  }
  if (changes.field_of_view <= 0 && !changes.projection) return;
  check_description(d);
  add_default_camera(d, changes.projection ? 0 : changes.field_of_view);
  for (Camera& camera : d.cameras) change_camera(camera, changes);
}

}  // namespace

void parse_environment(const std::string& text, SceneChanges& changes) {
  changes.uniform_radiance = parse_radiance(text);
  changes.environment_file = changes.uniform_radiance ? "" : text;
  const auto& l = changes.uniform_radiance;
  // No file's name is made of numbers and commas.
  const bool is_number = text.find_first_not_of("0123456789.,+-einfaINFA") == std::string::npos;
  if (l ? l->r < 0 || l->g < 0 || l->b < 0 : text.find(',') != std::string::npos && is_number)
    throw Error(fmt::format("--environment '{}' is no radiance of 0 or more", text),
                "Give an image file, or a radiance such as 1 or 0.5,0.6,0.8.");
}

std::array<Vec3d, 2> parse_look_at(const std::string& text) {
  const std::size_t half = text.find(';');
  const bool in_halves = half != std::string::npos && numbers_of<double>(text.substr(0, half)).size() == 3;
  std::string with_commas = text;
  if (in_halves) with_commas[half] = ',';
  const std::vector<double> v = numbers_of<double>(with_commas);
  if (v.size() != 6 || (v[0] == v[3] && v[1] == v[4] && v[2] == v[5]))
    throw Error(fmt::format("--look-at '{}' is not an eye and a target", text),
                "Give six numbers, the places of two different points, for example 0,1.6,5,0,1,0.");
  return {Vec3d{v[0], v[1], v[2]}, Vec3d{v[3], v[4], v[5]}};
}

Environment read_environment(const std::string& path, const std::shared_ptr<MemoryBudget>& budget) {
  const ImageFileHeader header = read_image_header(path);
  // Before the file is decoded: a small one may unpack to gigabytes.
  const Reservation room(
      *budget, "environment",
      environment_bytes(static_cast<std::uint64_t>(header.width) * static_cast<std::uint64_t>(header.height)));
  TextureLibrary library(0, budget);
  TextureOptions nearest;
  nearest.filter = TextureFilter::nearest;
  const std::shared_ptr<const TextureFile> image = library.open(path, nearest);
  Environment environment;
  environment.name = std::filesystem::path(path).filename().string();
  environment.width = image->width();
  environment.height = image->height();
  const std::size_t pixels = static_cast<std::size_t>(environment.width) * static_cast<std::size_t>(environment.height);
  environment.pixels.reserve(pixels);
  for (int y = 0; y < environment.height; ++y)
    for (int x = 0; x < environment.width; ++x)
      environment.pixels.push_back(
          image->color({(static_cast<float>(x) + 0.5f) / static_cast<float>(environment.width),
                        1 - (static_cast<float>(y) + 0.5f) / static_cast<float>(environment.height)}));
  if (environment.width == environment.height) {
    environment.mapping = EnvironmentMapping::equal_area;
    environment.to_world = {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0}};
  }
  return environment;
}

namespace {

void expand_instances(SceneDescription& d, MemoryBudget& budget) {
  std::uint64_t bytes = 0;
  for (const Instance& instance : d.geometry.instances) bytes += scene_bytes(*d.geometry.meshes[instance.mesh]);
  const Reservation room(budget, "copies of instances", bytes);
  d.geometry = d.geometry.expanded();
}

}  // namespace

void change_scene(SceneDescription& d, const SceneChanges& changes, const std::shared_ptr<MemoryBudget>& budget) {
  d.studio_light = changes.studio_light;
  for (const std::string& text : changes.materials) change_material(text, d, *budget);
  if (changes.expand_instances) expand_instances(d, *budget);
  if (!changes.volume.empty()) add_volume(changes.volume, d, *budget);
  const bool z_up = changes.z_up.value_or(d.z_up);
  if (z_up != d.z_up || changes.metres_per_unit != 1) change_space(d, z_up, changes.metres_per_unit);
  if (!changes.view_file.empty()) add_views(d, changes.view_file, *budget);
  change_cameras(d, changes);
  for (const std::string& text : changes.luminaires) d.lights.push_back(luminaire_of_text(text, d.z_up, d.origin));
  if (changes.visibility > 0) add_haze(d, changes.visibility);
  if (changes.luminous_openings) add_luminous_openings(d);
  if (!changes.sky.empty()) {
    add_sky(changes.sky, changes.environment_turn, d);
  } else if (changes.uniform_radiance) {
    d.environment = Environment{};
    d.environment->name = "environment";
    d.environment->scale = *changes.uniform_radiance;
  } else if (!changes.environment_file.empty()) {
    d.environment = read_environment(changes.environment_file, budget);
  }
  if (changes.environment_turn == 0 && changes.environment_scale == 1) return;
  if (!d.environment) {
    d.notes.push_back("--environment-turn and --environment-scale have no effect: the scene has no environment");
    return;
  }
  d.environment->scale *= changes.environment_scale;
  if (!changes.sky.empty()) return;  // it is turned with its sun
  const float c = std::cos(changes.environment_turn * kPi / 180), s = std::sin(changes.environment_turn * kPi / 180);
  d.environment->to_world = Transform{{c, 0, -s}, {0, 1, 0}, {s, 0, c}, {0, 0, 0}} * d.environment->to_world;
}

}  // namespace glowworm
