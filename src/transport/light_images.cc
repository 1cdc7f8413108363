#include "transport/light_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "bsdf/bsdf.h"
#include "transport/light_connection.h"
#include "transport/medium.h"
#include "transport/roulette.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// Images of a sun, and of all lamps together, at most: a ray each.
constexpr std::size_t kMostImages = 64;
/// Surfaces of one direction that have less than this share of the smooth area show none: facets of curved mirrors.
constexpr double kLeastSurface = 0.01;
/// Normals, and directions of suns, that differ by less (radians) are one.
constexpr float kNormalGrid = 1e-3f;
/// Planes of one normal are one if they are closer than this share of the scene's radius.
constexpr float kPlaneGrid = 1e-5f;
/// The least share of the light that is followed.
constexpr float kLeastOfLight = 1e-6f;
/// Tolerance of the images of a lamp, over the distance of the farthest from the lamp.
constexpr float kLampTolerance = 1e-4f;

/// Surfaces of one direction, or of one plane.
struct FlatSurfaces {
  double area = 0;
  float largest = 0;
  Vec3 normal;       ///< of the largest triangle
  float offset = 0;  ///< of its plane along the normal, metres
};

/// A normal of either side.
Vec3 one_sided(Vec3 n) {
  const float first = std::abs(n.x) > kNormalGrid ? n.x : std::abs(n.y) > kNormalGrid ? n.y : n.z;
  return first < 0 ? -n : n;
}

/// Whether a triangle is smooth in its middle.
bool is_smooth_in_the_middle(const Scene& scene, std::uint32_t triangle) {
  Vertex vertex;
  vertex.point = surface_point(scene, triangle, kMiddle);
  vertex.wo = vertex.point.geometric_normal;
  RGB color(1.0f);
  resolve_material(scene, vertex, color, [] { return 0.5f; });
  return is_smooth(scene, triangle, vertex);
}

/// Smooth surfaces by their directions, largest first. @param by_plane tell parallel planes apart
std::vector<FlatSurfaces> flat_surfaces(const Scene& scene, bool by_plane) {
  const Geometry& g = scene.geometry();
  enum class Kind : std::uint8_t { unknown, smooth, other };
  std::vector<Kind> kind(scene.materials().size(), Kind::unknown);
  std::map<std::array<long, 4>, FlatSurfaces> found;
  double all = 0;
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
    Kind& of_material = kind[g.material_of(t)];
    if (of_material == Kind::unknown) of_material = is_smooth_in_the_middle(scene, t) ? Kind::smooth : Kind::other;
    if (of_material != Kind::smooth) continue;
    const Vec3 n = one_sided(g.normal(t));
    const float area = g.area(t);
    all += area;
    const float offset = dot(n, surface_point(scene, t, {0, 0}).position);
    const auto key = [](float x) { return std::lround(x / kNormalGrid); };
    const long plane = by_plane ? std::lround(offset / (kPlaneGrid * scene.radius())) : 0;
    FlatSurfaces& surfaces = found[{key(n.x), key(n.y), key(n.z), plane}];
    surfaces.area += area;
    if (!(area > surfaces.largest)) continue;
    surfaces.largest = area;
    surfaces.normal = n;
    surfaces.offset = offset;
  }
  std::vector<FlatSurfaces> out;
  for (const auto& [key, surfaces] : found)
    if (surfaces.area > kLeastSurface * all) out.push_back(surfaces);
  std::stable_sort(out.begin(), out.end(),
                   [](const FlatSurfaces& a, const FlatSurfaces& b) { return a.area > b.area; });
  return out;
}

/// Irradiance across the light that a smooth lobe sends towards the viewer, over the irradiance across the
/// light that it takes. Refraction of parallel light scales this by its cross section, and not as radiance.
/// @param lobe index into smooth_lobes()
RGB passed_irradiance(const Vertex& vertex, std::size_t lobe) {
  const Vec3 view = vertex.surface().local_view(vertex.wo);
  const BsdfSample s = sample(vertex.bsdf, view, lobe == 0 ? 0 : kBelowOne, {0.5f, 0.5f}, kSpecular, Transport::flux);
  return s.weight * (s.pdf * std::abs(s.wi.z / view.z));
}

/// Follows the ways of a ray to a light.
class ImageTracer {
 public:
  /// @param distance of the image from the start of the ray, metres; infinite for suns
  ImageTracer(const Tracer& tracer, const ImagedLight& light, float distance)
      : tracer_(tracer), light_(light), distance_(distance) {}

  /// @param left metres to the light
  void follow(PathState path, float left, bool bent, int bounces) {
    const Scene& scene = tracer_.scene();
    ++rays;
    Hit hit = tracer_.intersect(path.ray, RayOrder::partly);
    const bool meets_surface = travel(tracer_, path, hit, RayOrder::partly, [&](const Medium* medium, float length) {
      // The lamp may touch a surface.
      const bool ends = length >= left * (1 - kShadowError);
      if (medium) path.throughput *= transmittance(*medium, path.ray, ends ? left : length);
      if (ends && bent) arrive(path, left);
      left -= length;
      return !ends && max_component(path.throughput) >= kLeastOfLight;
    });
    if (!meets_surface || bounces == kEvenBounces) return;
    Vertex vertex = vertex_at(scene, path.ray, hit);
    if (!scene.media().empty()) vertex.media = media_at(scene, path.medium, hit.triangle, vertex.wo);
    if (const float present = coverage(scene, hit.triangle, vertex.point.texture); present < 1) {
      PathState beyond = path;
      beyond.throughput *= 1 - present;
      beyond.ray = leave_surface(vertex.point.position, -vertex.normal(), vertex.point.offset, path.ray.direction, 0);
      follow(beyond, left, bent, bounces + 1);
      path.throughput *= present;
    }
    RGB of_color(1.0f);
    resolve_material(scene, vertex, of_color, [] { return 0.5f; });
    if (!is_smooth(scene, hit.triangle, vertex)) return;
    const SmoothLobes lobes = smooth_lobes(vertex);
    for (std::size_t i = 0; i < lobes.count; ++i) {
      const ScatteredRay& lobe = lobes.ray[i];
      const bool refracts = !lobe.is_null && dot(lobe.direction, vertex.normal()) < 0;
      PathState next = path;
      if ((refracts && !light_.is_far()) || !leave(next, vertex, lobe, passed_irradiance(vertex, i))) continue;
      if (max_component(next.throughput) >= kLeastOfLight) follow(next, left, bent || !lobe.is_null, bounces + 1);
    }
  }

  RGB found{0.0f};
  std::uint64_t rays = 0;

 private:
  void arrive(const PathState& path, float left) {
    const Vec3 direction = path.ray.direction;
    if (light_.is_far()) {
      if (light_.same(direction, light_.images.front())) found += path.throughput * light_.light.intensity;
    } else if (light_.same(path.ray.origin + direction * left, light_.light.position)) {
      found += path.throughput * sample_delta(light_.light, light_.light.position - direction * distance_).radiance;
    }
  }

  const Tracer& tracer_;
  const ImagedLight& light_;
  const float distance_;
};

}  // namespace

bool ImagedLight::has(Vec3 image) const {
  return std::any_of(images.begin(), images.end(), [&](Vec3 other) { return same(image, other); });
}

std::vector<LightImages::Reflection> LightImages::reflections(const Scene& scene, LightKind of, std::size_t most) {
  const std::vector<FlatSurfaces> surfaces = flat_surfaces(scene, of != LightKind::directional);
  std::vector<Reflection> out;
  if (surfaces.empty()) return out;
  const auto add = [&](Reflection reflection) {
    if (out.size() < most) out.push_back(std::move(reflection));
  };
  const auto mirror = [](const FlatSurfaces& s) { return Mirror{s.normal, s.offset}; };
  add({});
  for (const FlatSurfaces& only : surfaces) add({mirror(only)});
  for (const FlatSurfaces& first : surfaces)
    for (const FlatSurfaces& second : surfaces)
      if (&first != &second) add({mirror(first), mirror(second)});
  return out;
}

LightImages::LightImages(const Scene& scene) : of_suns_(reflections(scene, LightKind::directional, kMostImages)) {}

LightImages LightImages::of_lights(const Scene& scene) {
  LightImages out;
  if (scene.light_selector().directional_count() > 0) out = LightImages(scene);
  const auto is_lamp = [](const Light& l) { return l.kind != LightKind::directional && !is_black(l.intensity); };
  const auto lamps = static_cast<std::size_t>(std::count_if(scene.lights().begin(), scene.lights().end(), is_lamp));
  // The lamp itself takes no ray.
  if (lamps > 0 && lamps <= kMostImages) out.of_lamps_ = reflections(scene, LightKind::point, kMostImages / lamps + 1);
  return out;
}

ImagedLight LightImages::of(const Light& light) const {
  ImagedLight out{light, {}, kNormalGrid};
  const Vec3 start = out.is_far() ? -light.direction : light.position;
  std::vector<Vec3> all;
  float farthest = 0;  // squared
  for (const Reflection& reflection : out.is_far() ? of_suns_ : of_lamps_) {
    Vec3 image = start;
    for (auto m = reflection.rbegin(); m != reflection.rend(); ++m)
      image = image - m->normal * (2 * (dot(image, m->normal) - (out.is_far() ? 0 : m->offset)));
    all.push_back(out.is_far() ? normalize(image) : image);
    farthest = std::max(farthest, length_squared(image - start));
  }
  if (!out.is_far()) out.tolerance = kLampTolerance * std::sqrt(farthest);
  for (const Vec3 image : all) {
    const auto near = [&](Vec3 other) { return length_squared(image - other) < 4 * out.tolerance * out.tolerance; };
    if (std::none_of(out.images.begin(), out.images.end(), near)) out.images.push_back(image);
  }
  return out;
}

Light sun_towards(Vec3 to_sun) {
  Light out;
  out.kind = LightKind::directional;
  out.direction = -to_sun;
  return out;
}

bool is_smooth(const Scene& scene, std::uint32_t triangle, const Vertex& vertex) {
  return scene.materials()[scene.geometry().material_of(triangle)].kind != MaterialKind::mix && vertex.has(kSpecular) &&
         smooth_lobes(vertex).count > 0;
}

RGB light_of_image(const Tracer& tracer, Vec3 origin, PathMedium medium, const ImagedLight& light, Vec3 image,
                   std::uint64_t& rays) {
  if (!light.is_far() && light.same(image, light.light.position)) return RGB(0.0f);
  const float distance = light.is_far() ? std::numeric_limits<float>::infinity() : length(image - origin);
  ImageTracer tracing(tracer, light, distance);
  PathState path;
  path.ray = {origin, 0, light.direction(image, origin), std::numeric_limits<float>::infinity()};
  path.medium = medium;
  tracing.follow(path, distance, false, 0);
  rays += tracing.rays;
  return tracing.found;
}

}  // namespace glowworm
