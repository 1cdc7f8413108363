#include "scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/coordinate_origin.h"
#include "core/error.h"
#include "core/names.h"
#include "core/parallel.h"
#include "scene/default_camera.h"
#include "scene/environment.h"
#include "scene/light_power.h"
#include "scene/repeated_triangles.h"
#include "scene/scene_checks.h"
#include "scene/studio_light.h"

namespace glowworm {

namespace {

/// The corners of the ambient medium's box: none if it has no bounds.
std::vector<Vec3> ambient_corners(const SceneDescription& d) {
  if (d.ambient_medium == kNone || !d.media[d.ambient_medium].bounds) return {};
  const Medium& medium = d.media[d.ambient_medium];
  const Transform to_world = inverse(medium.to_medium);
  const Vec3 ends[] = {medium.bounds->min, medium.bounds->max};
  std::vector<Vec3> out;
  for (int i = 0; i < 8; ++i) out.push_back(to_world.point({ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z}));
  return out;
}

/// Whether an alpha test could ever let a ray pass.
bool may_be_absent(const Material& m, const std::vector<TextureNode>& textures) {
  if (m.alpha.texture == kNone) return m.alpha_cutoff >= 0 ? m.alpha.value < m.alpha_cutoff : m.alpha.value < 1;
  const TextureNode& node = textures[m.alpha.texture];
  const bool opaque_image = node.kind == TextureKind::image && m.alpha.channel == Channel::alpha &&
                            !node.image->has_alpha() && m.alpha.value >= 1;
  return !opaque_image;
}

/// For each material whether any point of it may be a pane.
std::vector<bool> find_panes(const std::vector<Material>& materials) {
  std::vector<bool> panes;
  for (const Material& m : materials)
    panes.push_back(m.kind == MaterialKind::thin_dielectric || m.kind == MaterialKind::interface ||
                    (m.kind == MaterialKind::metallic_roughness && m.thin && m.transmission.value > 0));
  // The parts of a mix may come before or after it, and may be mixes themselves.
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < panes.size(); ++i) {
      const Material& m = materials[i];
      if (m.kind != MaterialKind::mix || panes[i] || !(panes[m.mix_a] || panes[m.mix_b])) continue;
      changed = panes[i] = true;
    }
  }
  return panes;
}

/// Makes the axes of an environment orthonormal: scale has no meaning for directions, and shear would distort the sky.
void straighten(Environment& environment, std::vector<std::string>& notes) {
  Transform& m = environment.to_world;
  const Vec3 x = normalize(m.x), y = normalize(m.y - x * dot(x, m.y));
  Vec3 z = cross(x, y);
  if (dot(z, m.z) < 0) z = -z;
  if (dot(y, normalize(m.y)) < 0.999f || dot(z, normalize(m.z)) < 0.999f)
    notes.push_back(
        fmt::format("environment \"{}\": its transform is sheared; only its turning is used", environment.name));
  m = {x, y, z, {0, 0, 0}};
}

/// Normalises values of a description whose meaning is clear.
void normalize_lights(SceneDescription& d) {
  for (Light& light : d.lights) {
    if (length_squared(light.direction) > 0) light.direction = normalize(light.direction);
    if (light.kind == LightKind::luminaire)
      light.right = normalize(light.right - light.direction * dot(light.right, light.direction));
    light.cos_outer = std::clamp(light.cos_outer, -1.0f, 1.0f);
    light.cos_inner = std::clamp(light.cos_inner, light.cos_outer, 1.0f);
  }
  if (!d.environment) return;
  straighten(*d.environment, d.notes);
  std::size_t mended = 0;
  for (RGB& texel : d.environment->pixels) {
    if (is_finite(texel) && texel.r >= 0 && texel.g >= 0 && texel.b >= 0) continue;
    for (int c = 0; c < 3; ++c) texel[c] = std::isfinite(texel[c]) ? std::max(texel[c], 0.0f) : 0.0f;
    ++mended;
  }
  if (mended > 0)
    d.notes.push_back(
        fmt::format("environment \"{}\": {} texels are negative or not finite; set to 0", d.environment->name, mended));
}

/// Whether the file has lights, though they may be black. A texture of emission that is black makes none.
bool has_lights(const SceneDescription& d, const Geometry& geometry) {
  return !d.lights.empty() || d.environment || std::any_of(d.media.begin(), d.media.end(), emits) ||
         std::any_of(geometry.emission.begin(), geometry.emission.end(), [&](std::uint32_t emission) {
           return emission != kNone && d.emissions[emission].radiance.texture == kNone;
         });
}

void add_studio_light(SceneDescription& d) {
  d.environment = studio_light(d.cameras.front());
  d.notes.push_back(d.emissions.empty() ? "the scene has no light; a studio light was added"
                                        : "the scene has no light but what glows on its surfaces; a studio light was "
                                          "added");
}

/// Whether surfaces part media. Interfaces that emit, as openings of luminaires do, part none.
bool has_interfaces(const std::vector<Material>& materials, const Geometry& g) {
  std::vector<bool> is_interface;
  for (const Material& m : materials) is_interface.push_back(m.kind == MaterialKind::interface);
  if (std::none_of(is_interface.begin(), is_interface.end(), [](bool is) { return is; })) return false;
  for (std::uint32_t t = 0; t < g.triangles.size(); ++t)
    if (is_interface[g.material[t]] && g.emission[t] == kNone) return true;
  return std::any_of(g.meshes.begin(), g.meshes.end(), [&](const auto& mesh) {
    return std::any_of(mesh->material.begin(), mesh->material.end(), [&](std::uint32_t m) { return is_interface[m]; });
  });
}

/// Moves a distant scene to the origin, unless its reader has done so, and returns what was subtracted. Differences of
/// its coordinates are exact (Sterbenz).
Vec3 move_to_origin(SceneDescription& d) {
  if (!(d.origin == Vec3{0, 0, 0})) return d.origin;
  const Box3 box = d.geometry.bounds();
  const Vec3 origin = origin_for(Vec3d(box.min), Vec3d(box.max));
  if (origin == Vec3{0, 0, 0}) return origin;
  for (Vec3& p : d.geometry.positions) p -= origin;
  for (Instance& instance : d.geometry.instances) instance.to_world.translation -= origin;
  for (Light& light : d.lights) light.position -= origin;
  for (Camera& camera : d.cameras) camera.to_world.translation -= origin;
  for (Medium& medium : d.media) medium.to_medium.translation += medium.to_medium.vector(origin);
  return origin;
}

/// Notes what was subtracted from all positions.
void note_origin(Vec3 origin, std::vector<std::string>& notes) {
  if (origin == Vec3{0, 0, 0}) return;
  notes.push_back(
      fmt::format("the scene lies far from its origin: ({}, {}, {}) m is subtracted from its coordinates while it is "
                  "rendered. Give places in the file's coordinates",
                  double{origin.x}, double{origin.y}, double{origin.z}));
}

/// Share of the triangles that are short compared to the rounding of their coordinates.
struct ShortTriangles {
  float share = 0, farthest = 0;  ///< farthest: largest coordinate of one, metres
};

/// Instances are left out: their meshes are near their own origins.
/// @param origin what was subtracted from all positions
ShortTriangles short_triangles(const Geometry& g, Vec3 origin) {
  // A number is rounded to 2^-23 to 2^-24 of itself: these are 50 to 100 roundings.
  constexpr float kShort = 100 * 0x1p-24f;
  ShortTriangles out;
  std::size_t count = 0;
  for (const auto& [a, b, c] : g.triangles) {
    const Vec3 p = g.positions[a], q = g.positions[b], r = g.positions[c], at = p + origin;
    const float largest = std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)});
    const float longest = std::max({length_squared(q - p), length_squared(r - q), length_squared(p - r)});
    if (!(longest < kShort * kShort * largest * largest)) continue;
    ++count;
    out.farthest = std::max(out.farthest, largest);
  }
  out.share = static_cast<float>(count) / static_cast<float>(std::max<std::size_t>(g.triangles.size(), 1));
  return out;
}

/// Adds a note if vertices were rounded so far from the origin that it shows: if the scene lies a thousand sizes away,
/// by more than 1/17,000 of it; or if a tenth of the triangles are short, as of a house in a wide land.
void note_rounding(const Geometry& geometry, Vec3 origin, float size, std::vector<std::string>& notes) {
  constexpr float kFar = 1000, kManyShort = 0.1f;
  const auto note = [&](const std::string& what, float coordinate) {
    const float step = std::nextafter(coordinate, std::numeric_limits<float>::infinity()) - coordinate;
    notes.push_back(
        fmt::format("{}, where coordinates are rounded to {:.2g} m, which bends its shapes. Move it to the "
                    "origin before you export it",
                    what, step));
  };
  const float largest = std::max({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z)});
  if (largest > kFar * size)
    return note(fmt::format("the scene lies {:.0f} times its size from the origin", largest / size), largest);
  const ShortTriangles found = short_triangles(geometry, origin);
  if (found.share > kManyShort)
    note(fmt::format("{:.0f}% of the scene's triangles are small and far from the origin", 100 * found.share),
         found.farthest);
}

float power_weight(RGB power) {
  if (!is_finite(power))
    throw Error(fmt::format("a light has a power of ({:g}, {:g}, {:g}) W", power.r, power.g, power.b),
                "Give it a smaller value, or scale the scene down.");
  return std::max(luminance(power), 0.0f);
}

/// Media that nothing is filled with, as pbrt files may define, are no lights.
void darken_unused_media(SceneDescription& d) {
  for (std::uint32_t i = 0; i < d.media.size(); ++i) {
    const auto names_it = [&](const Material& m) { return m.inside == i || m.outside == i; };
    if (i != d.ambient_medium && std::none_of(d.materials.begin(), d.materials.end(), names_it))
      d.media[i].emission = RGB(0.0f);
  }
}

}  // namespace

bool LightPowers::are_as(const std::vector<RGB>& others) const {
  // Any choice gives the right light. The area of a small triangle far from the origin changes by rounding.
  constexpr float kNearly = 0.01f;
  if (of_sources.size() != others.size()) return false;
  for (std::size_t i = 0; i < others.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (!(std::abs(others[i][c] - of_sources[i][c]) <= kNearly * of_sources[i][c])) return false;
  return true;
}

Box3 box_of_air(const Box3& surfaces, const std::vector<Camera>& cameras, const std::vector<Light>& lights) {
  constexpr float kMargin = 0.02f;  // of the diagonal
  Box3 box = surfaces;
  for (const Camera& camera : cameras) box.grow(camera.to_world.translation);
  for (const Light& light : lights)
    if (light.kind != LightKind::directional) box.grow(light.position);
  const float margin = kMargin * length(box.diagonal());
  return {box.min - Vec3{margin, margin, margin}, box.max + Vec3{margin, margin, margin}};
}

Scene::Scene(SceneDescription description) : d_(std::move(description)) {
  d_.geometry.number_instances();
  check_description(d_);
  darken_unused_media(d_);
  normalize_lights(d_);
  origin_ = move_to_origin(d_);
  add_default_camera(d_);
  if (d_.studio_light && needs_studio_light(d_)) add_studio_light(d_);
  geometry_ = std::make_shared<const Geometry>(std::exchange(d_.geometry, {}));
  bound_ambient_medium();
  measure();
  note_origin(to_file_axes(origin_) + Vec3{0, 0, 0}, d_.notes);  // + 0 writes 0 in place of -0
  note_rounding(*geometry_, d_.origin_is_exact ? Vec3{0, 0, 0} : origin_, length(bounds_.diagonal()), d_.notes);
  for (const Material& m : d_.materials) material_has_alpha_.push_back(may_be_absent(m, d_.textures));
  material_is_pane_ = find_panes(d_.materials);
  crosses_media_ = !d_.media.empty() || has_interfaces(d_.materials, *geometry_);
  find_repeated();
  emissive_media_ = find_emissive_media(d_.media, d_.materials, *geometry_, d_.ambient_medium);
  find_light_sources();
  check_dimness(d_, radius_);
  if (light_power_.total() > 0) return;
  if (has_lights(d_, *geometry_)) {
    d_.notes.push_back("all lights of the scene are black");
    return;
  }
  if (!d_.studio_light) {
    d_.notes.push_back("the scene has no light");
    return;
  }
  add_studio_light(d_);
  if (bound_ambient_medium()) measure();
  find_light_sources();
}

Scene::Scene(const Scene& scene, SceneEdit edit)
    : d_(scene.d_),
      geometry_(scene.geometry_),
      diffuse_triangles_(scene.diffuse_triangles_),
      stored_triangles_(scene.stored_triangles_),
      repeated_(scene.repeated_),
      origin_(scene.origin_),
      smooth_(scene.smooth_),
      bounds_(scene.bounds_),
      radius_(scene.radius_),
      lit_sphere_(scene.lit_sphere_),
      emissive_media_(scene.emissive_media_),
      material_has_alpha_(scene.material_has_alpha_),
      material_is_pane_(scene.material_is_pane_),
      crosses_media_(scene.crosses_media_) {
  const bool same_triangles = !edit.geometry || edit.geometry->triangle_count() == geometry_->triangle_count();
  if (edit.emissions.size() != d_.emissions.size() || edit.lights.size() < d_.lights.size() || !same_triangles)
    throw Error("the edit is of another scene");
  d_.emissions = std::move(edit.emissions);
  d_.lights = std::move(edit.lights);
  d_.environment = std::move(edit.environment);
  d_.cameras.insert(d_.cameras.end(), edit.more_cameras.begin(), edit.more_cameras.end());
  if (!edit.name.empty()) d_.name = std::move(edit.name);
  check_lights(d_);
  check_cameras(d_);
  normalize_lights(d_);
  const bool same_instances = !edit.geometry || edit.geometry->instances.size() == geometry_->instances.size();
  const bool moves = edit.geometry != nullptr;
  if (moves) geometry_ = std::move(edit.geometry);
  if (bound_ambient_medium() || moves) {
    measure();
    emissive_media_ = find_emissive_media(d_.media, d_.materials, *geometry_, d_.ambient_medium);
    if (!same_instances) find_repeated();
  }
  find_light_sources();
  if (edit.lit_as && edit.lit_as->are_as(source_powers_)) light_power_ = std::move(edit.lit_as->choice);
}

bool Scene::bound_ambient_medium() {
  if (d_.ambient_medium == kNone || d_.media[d_.ambient_medium].bounds) return false;
  const bool is_lit_from_afar =
      d_.environment || std::any_of(d_.lights.begin(), d_.lights.end(),
                                    [](const Light& light) { return light.kind == LightKind::directional; });
  if (!is_lit_from_afar) return false;
  Medium& medium = d_.media[d_.ambient_medium];
  medium.to_medium = {};
  medium.bounds = box_of_air(geometry_->bounds(), d_.cameras, d_.lights);
  return true;
}

void Scene::measure() {
  diffuse_triangles_ =
      std::make_shared<const LargeVector<DiffuseTriangle>>(diffuse_triangles(*geometry_, d_.materials));
  stored_triangles_ = static_cast<std::uint32_t>(diffuse_triangles_->size());
  const auto has_normals = [](const Geometry& g) {
    return std::any_of(g.normals.begin(), g.normals.end(), [](Vec3 n) { return !(n == Vec3{0, 0, 0}); });
  };
  smooth_ = has_normals(*geometry_) || std::any_of(geometry_->meshes.begin(), geometry_->meshes.end(),
                                                   [&](const auto& mesh) { return has_normals(*mesh); });
  bounds_ = geometry_->bounds();
  const std::vector<Vec3> around = ambient_corners(d_);
  Box3 whole = bounds_;
  for (const Vec3 corner : around) whole.grow(corner);
  radius_ = 0;
  lit_sphere_ = {whole.center(), 0};
  geometry_->for_each_position([&](const Vec3& p) {
    radius_ = std::max(radius_, length(p - center()));
    lit_sphere_.radius = std::max(lit_sphere_.radius, length(p - lit_sphere_.center));
  });
  for (const Vec3 corner : around)
    lit_sphere_.radius = std::max(lit_sphere_.radius, length(corner - lit_sphere_.center));
}

void Scene::find_repeated() {
  auto repeated = repeated_triangles(*geometry_, material_has_alpha_);
  if (const auto count = std::count(repeated.begin(), repeated.end(), true); count > 0)
    d_.notes.push_back(fmt::format("{} triangles repeat others in the same place; rays meet the first of each", count));
  repeated_ = std::make_shared<const std::vector<bool>>(std::move(repeated));
  const std::vector<bool> instances = repeated_instances(*geometry_, material_has_alpha_);
  if (const auto count = std::count(instances.begin(), instances.end(), true); count > 0)
    d_.notes.push_back(fmt::format("{} instances repeat others in the same place; rays meet the first of each", count));
}

void Scene::find_light_sources() {
  const Geometry& g = *geometry_;
  const float disc = kPi * lit_sphere_.radius * lit_sphere_.radius;
  emissive_triangles_.clear();
  emissive_index_.assign(g.triangles.size(), kNone);
  source_powers_.clear();
  std::vector<std::uint32_t> emitting;
  for (std::uint32_t t = 0; t < g.triangles.size(); ++t)
    if (g.emission[t] != kNone && !repeats(t) && !is_black(d_.emissions[g.emission[t]].radiance.value))
      emitting.push_back(t);
  const std::vector<RGB> powers = triangle_powers(g, d_, emitting);
  for (std::size_t i = 0; i < emitting.size(); ++i) {
    const std::uint32_t t = emitting[i];
    const RGB power = powers[i];
    if (is_black(power) && d_.emissions[g.emission[t]].radiance.texture != kNone) continue;
    emissive_index_[t] = static_cast<std::uint32_t>(emissive_triangles_.size());
    emissive_triangles_.push_back(t);
    source_powers_.push_back(power);
  }
  for (const Light& light : d_.lights) source_powers_.push_back(glowworm::light_power(light, lit_sphere_.radius));
  for (const MediumEmission& emission : emissive_media_) source_powers_.push_back(emission.power());
  if (d_.environment) {
    source_powers_.push_back(environment_integral(*d_.environment) * disc);
    environment_distribution_ = glowworm::environment_distribution(*d_.environment);
  }
  if (emissive_triangles_.empty()) emissive_index_.clear();
  std::vector<float> weights;
  for (const RGB& power : source_powers_) weights.push_back(power_weight(power));
  light_power_ = Distribution1D(weights);
  light_selector_ =
      LightSelector(g, emissive_triangles_, d_.emissions, d_.lights, emissive_media_.size(), weights, disc);
}

std::uint32_t Scene::source_of_medium(std::uint32_t medium) const {
  for (std::uint32_t i = 0; i < emissive_media_.size(); ++i)
    if (emissive_media_[i].medium() == medium) return first_medium_source() + i;
  return kNone;
}

const Camera& Scene::camera(const std::string& name) const {
  if (name.empty()) return d_.cameras.front();
  std::vector<std::string> names;
  for (const Camera& camera : d_.cameras) names.push_back(camera.name);
  return d_.cameras[name_index("the camera", name, names)];
}

}  // namespace glowworm
