#include "transport/sun_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "bsdf/bsdf.h"
#include "transport/medium.h"
#include "transport/roulette.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// Images at most: a ray each.
constexpr std::size_t kMostImages = 64;
/// Surfaces of one direction that have less than this share of the smooth area show none: facets of curved mirrors.
constexpr double kLeastSurface = 0.01;
/// Normals that differ by less are one.
constexpr float kNormalGrid = 1e-3f;
/// The least share of the sun's light that is followed.
constexpr float kLeastOfSun = 1e-6f;

/// Surfaces of one direction.
struct FlatSurfaces {
  double area = 0;
  float largest = 0;
  Vec3 normal;  ///< of the largest triangle
};

/// A normal of either side.
Vec3 one_sided(Vec3 n) {
  const float first = std::abs(n.x) > kNormalGrid ? n.x : std::abs(n.y) > kNormalGrid ? n.y : n.z;
  return first < 0 ? -n : n;
}

/// Whether a triangle is smooth in its middle.
bool is_smooth_in_the_middle(const Scene& scene, std::uint32_t triangle) {
  constexpr float kThird = 1.0f / 3;
  Vertex vertex;
  vertex.point = surface_point(scene, triangle, {kThird, kThird});
  vertex.wo = vertex.point.geometric_normal;
  RGB color(1.0f);
  resolve_material(scene, vertex, color, [] { return 0.5f; });
  return is_smooth(scene, triangle, vertex);
}

/// Smooth surfaces by their directions, largest first.
std::vector<FlatSurfaces> flat_surfaces(const Scene& scene) {
  const Geometry& g = scene.geometry();
  enum class Kind : std::uint8_t { unknown, smooth, other };
  std::vector<Kind> kind(scene.materials().size(), Kind::unknown);
  std::map<std::array<int, 3>, FlatSurfaces> found;
  double all = 0;
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
    Kind& of_material = kind[g.material_of(t)];
    if (of_material == Kind::unknown) of_material = is_smooth_in_the_middle(scene, t) ? Kind::smooth : Kind::other;
    if (of_material != Kind::smooth) continue;
    const Vec3 n = one_sided(g.normal(t));
    const float area = g.area(t);
    all += area;
    const auto key = [](float x) { return static_cast<int>(std::lround(x / kNormalGrid)); };
    FlatSurfaces& surfaces = found[{key(n.x), key(n.y), key(n.z)}];
    surfaces.area += area;
    if (!(area > surfaces.largest)) continue;
    surfaces.largest = area;
    surfaces.normal = n;
  }
  std::vector<FlatSurfaces> out;
  for (const auto& [key, surfaces] : found)
    if (surfaces.area > kLeastSurface * all) out.push_back(surfaces);
  std::stable_sort(out.begin(), out.end(),
                   [](const FlatSurfaces& a, const FlatSurfaces& b) { return a.area > b.area; });
  return out;
}

Vec3 mirrored(Vec3 v, Vec3 normal) { return v - normal * (2 * dot(v, normal)); }

/// Irradiance across the parallel light that a smooth lobe sends towards the viewer, over the irradiance across the
/// light that it takes. Refraction scales this by the cross section of the light, and not as radiance.
/// @param lobe index into smooth_lobes()
RGB passed_irradiance(const Vertex& vertex, std::size_t lobe) {
  constexpr float kFirst = 0, kLast = 0x1.fffffep-1f;
  const Vec3 view = vertex.surface().local_view(vertex.wo);
  const BsdfSample s = sample(vertex.bsdf, view, lobe == 0 ? kFirst : kLast, {0.5f, 0.5f}, kSpecular, Transport::flux);
  return s.weight * (s.pdf * std::abs(s.wi.z / view.z));
}

/// Follows the ways of a ray to the sun.
class ImageTracer {
 public:
  ImageTracer(const Tracer& tracer, Vec3 to_sun) : tracer_(tracer), to_sun_(to_sun) {}

  void follow(PathState path, bool bent, int bounces) {
    const Scene& scene = tracer_.scene();
    ++rays;
    Hit hit = tracer_.intersect(path.ray, RayOrder::incoherent);
    const bool arrives = travel(tracer_, path, hit, RayOrder::incoherent, [&](const Medium* medium, float length) {
      if (medium) path.throughput *= transmittance(*medium, path.ray, length);
      return max_component(path.throughput) >= kLeastOfSun;
    });
    if (!arrives) return;
    if (hit.triangle == kNone) {
      if (bent && SunImages::same(path.ray.direction, to_sun_)) found += path.throughput;
      return;
    }
    if (bounces == kEvenBounces) return;
    Vertex vertex = vertex_at(scene, path.ray, hit);
    if (!scene.media().empty()) vertex.media = media_at(scene, path.medium, hit.triangle, vertex.wo);
    RGB of_color(1.0f);
    resolve_material(scene, vertex, of_color, [] { return 0.5f; });
    if (!is_smooth(scene, hit.triangle, vertex)) return;
    const SmoothLobes lobes = smooth_lobes(vertex);
    for (std::size_t i = 0; i < lobes.count; ++i) {
      const ScatteredRay& lobe = lobes.ray[i];
      PathState next = path;
      if (!leave(next, vertex, lobe, passed_irradiance(vertex, i))) continue;
      if (max_component(next.throughput) >= kLeastOfSun) follow(next, bent || !lobe.is_null, bounces + 1);
    }
  }

  RGB found{0.0f};
  std::uint64_t rays = 0;

 private:
  const Tracer& tracer_;
  const Vec3 to_sun_;
};

}  // namespace

SunImages::SunImages(const Scene& scene) {
  const std::vector<FlatSurfaces> surfaces = flat_surfaces(scene);
  if (surfaces.empty()) return;
  const auto add = [&](Reflection reflection) {
    if (reflections_.size() < kMostImages) reflections_.push_back(std::move(reflection));
  };
  add({});
  for (const FlatSurfaces& only : surfaces) add({only.normal});
  for (const FlatSurfaces& first : surfaces)
    for (const FlatSurfaces& second : surfaces)
      if (&first != &second) add({first.normal, second.normal});
}

SunImages SunImages::of_lights(const Scene& scene) {
  return scene.light_selector().has_directional() ? SunImages(scene) : SunImages();
}

std::vector<Vec3> SunImages::of(Vec3 to_sun) const {
  constexpr float kApart = 2 * kTolerance;
  std::vector<Vec3> out;
  for (const Reflection& reflection : reflections_) {
    Vec3 direction = to_sun;
    for (auto normal = reflection.rbegin(); normal != reflection.rend(); ++normal)
      direction = mirrored(direction, *normal);
    direction = normalize(direction);
    const auto near = [&](Vec3 other) { return squared_distance(direction, other) < kApart * kApart; };
    if (std::none_of(out.begin(), out.end(), near)) out.push_back(direction);
  }
  return out;
}

bool is_smooth(const Scene& scene, std::uint32_t triangle, const Vertex& vertex) {
  return scene.materials()[scene.geometry().material_of(triangle)].kind != MaterialKind::mix && vertex.has(kSpecular) &&
         smooth_lobes(vertex).count > 0;
}

RGB light_of_image(const Tracer& tracer, Vec3 origin, PathMedium medium, Vec3 direction, Vec3 to_sun,
                   std::uint64_t& rays) {
  ImageTracer image(tracer, to_sun);
  PathState path;
  path.ray = {origin, 0, direction, std::numeric_limits<float>::infinity()};
  path.medium = medium;
  image.follow(path, false, 0);
  rays += image.rays;
  return image.found;
}

}  // namespace glowworm
