#include "measure/sky_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/parallel.h"
#include "measure/measurement.h"
#include "transport/light_connection.h"
#include "transport/medium.h"
#include "transport/step.h"
#include "transport/vertex.h"

namespace glowworm {

namespace {

/// Bounces of a way at most, and the least share of the sky's light that is followed.
constexpr int kMostBounces = 12;
constexpr float kLeastShare = 1e-3f;
/// The radius of the disc that stands for the sun in mirrors, over the distance of ways.
constexpr double kDiscOverSpacing = 2;
constexpr double kSunSolidAngle = M_PI * kSunRadius * kSunRadius;
/// Images of the sun that are closer than so many radii of that disc are one.
constexpr double kOneImage = 3;

/// Follows ways through smooth lobes.
class WayTracer {
 public:
  /// @param glints as of sky_rays() @param share of a pixel that a way has
  WayTracer(const Tracer& tracer, float share, bool with_glints, std::vector<SkyRay>& out, GatherPoints& glints)
      : tracer_(tracer), share_(share), with_glints_(with_glints), out_(out), glints_(glints) {}

  void follow(PathState path, SkyRay way, int bounces = 0) {
    const Scene& scene = tracer_.scene();
    const RayOrder order = bounces == 0 ? RayOrder::camera : RayOrder::incoherent;
    Hit hit = tracer_.intersect(path.ray, order);
    const bool arrives = travel(tracer_, path, hit, order, [&](const Medium* medium, float length) {
      if (medium) path.throughput *= transmittance(*medium, path.ray, length);
      return luminance(path.throughput) >= kLeastShare;
    });
    if (!arrives) return;
    if (hit.triangle == kNone) {
      way.towards = path.ray.direction;
      way.share = luminance(path.throughput);
      out_.push_back(way);
      return;
    }
    if (bounces == kMostBounces) return;
    Vertex vertex = vertex_at(scene, path.ray, hit);
    if (!scene.media().empty()) vertex.media = media_at(scene, path.medium, hit.triangle, vertex.wo);
    // Colours of dispersive glass are taken together.
    RGB of_color(1.0f);
    resolve_material(scene, vertex, of_color, [] { return 0.5f; });
    if (!vertex.has(kSpecular)) return;
    const SmoothLobes lobes = smooth_lobes(vertex);
    if (lobes.count == 0 && with_glints_)
      add_gather_point(glints_, vertex, path.throughput * share_, way.pixel, 0, 0, !scene.media().empty());
    for (std::size_t i = 0; i < lobes.count; ++i) {
      const ScatteredRay& lobe = lobes.ray[i];
      PathState next = path;
      if (!leave(next, vertex, lobe, lobe.weight * lobe.pdf) || luminance(next.throughput) < kLeastShare) continue;
      SkyRay on = way;
      on.bent |= !lobe.is_null;
      follow(next, on, bounces + 1);
    }
  }

 private:
  const Tracer& tracer_;
  const float share_;
  const bool with_glints_;
  std::vector<SkyRay>& out_;
  GatherPoints& glints_;
};

/// A direction in the axes of GlareSource.
Vec3 in_view(const Camera& camera, Vec3 d) {
  const Transform& m = camera.to_world;
  return {dot(d, normalize(m.x)), dot(d, normalize(m.y)), dot(d, normalize(m.z))};
}

GlareSource source_of(Vec3 seen, double luminance, double solid_angle) {
  GlareSource out;
  out.direction = seen;
  out.luminance = luminance;
  out.solid_angle = solid_angle;
  out.illuminance = luminance * solid_angle * seen.z;
  out.position_index = position_index(seen);
  return out;
}

/// An image of the sun in a mirror.
struct SunImage {
  Vec3 first, last;  ///< of its ways
  Vec3d seen;
  double solid_angle = 0, flux = 0;
};

}  // namespace

std::vector<SkyRay> sky_rays(const Tracer& tracer, const Camera& camera, int width, int height, int across,
                             bool straight, GatherPoints* glints) {
  std::vector<std::vector<SkyRay>> of_row(static_cast<std::size_t>(height));
  std::vector<GatherPoints> glints_of_row(of_row.size());
  const float share = 1 / static_cast<float>(across * across);
  const ScreenWindow window = screen_window(camera, width, height);
  const double area = double{window.right - window.left} * (window.top - window.bottom) /
                      (double{1} * width * height * across * across);
  const PathMedium around = camera_medium(tracer, camera);
  parallel_for_each(of_row.size(), 1, [&](std::size_t y) {
    WayTracer tracer_of_row(tracer, share, glints != nullptr, of_row[y], glints_of_row[y]);
    for (int x = 0; x < width; ++x)
      for (int i = 0; i < across * across; ++i) {
        const float u = (static_cast<float>(i % across) + 0.5f) / static_cast<float>(across);
        const float v = (static_cast<float>(i / across) + 0.5f) / static_cast<float>(across);
        const CameraRay ray =
            generate_ray(camera, {static_cast<float>(x) + u, static_cast<float>(y) + v}, width, height, {0.5f, 0.5f});
        if (ray.is_blind()) continue;
        SkyRay way;
        way.pixel = static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(width) + static_cast<std::uint32_t>(x);
        way.seen = in_view(camera, ray.direction);
        if (!(way.seen.z > 0)) continue;
        way.solid_angle =
            static_cast<float>(area * solid_angle_density(camera.kind, angular_plane(camera.kind, way.seen)));
        PathState path;
        path.ray = {ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()};
        path.medium = around;
        tracer_of_row.follow(path, way);
      }
    // Pictures of many pixels have no room for all.
    if (!straight) std::erase_if(of_row[y], [](const SkyRay& way) { return !way.bent; });
  });
  std::vector<SkyRay> out;
  for (const std::vector<SkyRay>& row : of_row) out.insert(out.end(), row.begin(), row.end());
  if (glints)
    for (const GatherPoints& row : glints_of_row) glints->append(row);
  return out;
}

std::vector<GlareSource> sources_of_sun(const Tracer& tracer, const Camera& camera, std::span<const SkyRay> rays,
                                        Vec3 to_sun, RGB irradiance) {
  std::vector<GlareSource> out;
  const Vec3 straight = in_view(camera, to_sun);
  if (straight.z > 0) {
    const RGB seen = passed_share(tracer, {irradiance,
                                           {camera.to_world.translation, 0, to_sun, HUGE_VALF},
                                           kNone,
                                           camera_medium(tracer, camera),
                                           {}}) *
                     irradiance;
    const double across = illuminance(seen);
    if (across > 0) out.push_back(source_of(straight, across / kSunSolidAngle, kSunSolidAngle));
  }
  std::vector<SunImage> images;
  const double luminance_of_sun = illuminance(irradiance) / kSunSolidAngle;
  for (const SkyRay& ray : rays) {
    if (!ray.bent) continue;
    const double radius = std::max(kDiscOverSpacing * std::sqrt(double{ray.solid_angle}), kSunRadius);
    if (!(length(cross(ray.towards, to_sun)) < radius) || !(dot(ray.towards, to_sun) > 0)) continue;
    const auto near = [&](const SunImage& image) {
      return length(cross(image.first, ray.seen)) < kOneImage * radius && dot(image.first, ray.seen) > 0;
    };
    auto image = std::find_if(images.begin(), images.end(), near);
    if (image == images.end()) image = images.insert(images.end(), {ray.seen, {0, 0, 0}, {}, 0, 0});
    const double solid_angle = ray.solid_angle * kSunSolidAngle / (M_PI * radius * radius);
    // Several ways of one ray, as by both faces of a pane, show the sun at the same place.
    if (!(std::exchange(image->last, ray.seen) == ray.seen)) image->solid_angle += solid_angle;
    image->flux += solid_angle * ray.share;
    image->seen = image->seen + Vec3d(ray.seen) * (solid_angle * ray.share);
  }
  for (const SunImage& image : images)
    out.push_back(source_of(narrow(image.seen * (1 / length(image.seen))),
                            luminance_of_sun * image.flux / image.solid_angle, image.solid_angle));
  return out;
}

}  // namespace glowworm
