#include "measure/sky_rays.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/parallel.h"
#include "measure/measurement.h"
#include "scene/light_sampling.h"
#include "scene/surface.h"
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
  /// @param out takes the ways that end in the sky; null: none
  /// @param glints as of sky_rays() @param share of a pixel that a way has
  WayTracer(const Tracer& tracer, std::vector<SkyRay>* out, GatherPoints* glints = nullptr, float share = 1)
      : tracer_(tracer), out_(out), glints_(glints), share_(share) {}

  /// What the ways since the last call have met: the light of lamps and sky that arrives, W sr^-1 m^-2, and whether
  /// one ended at a rough specular lobe, which shows lamps, too.
  struct Met {
    RGB light{0.0f};
    bool rough = false;
  };
  Met take_met() { return std::exchange(met_, {}); }

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
      if (out_) out_->push_back(way);
      met_.light += path.throughput * environment_radiance(scene, way.towards);
      return;
    }
    Vertex vertex = vertex_at(scene, path.ray, hit);
    if (scene.geometry().emission_of(hit.triangle) != kNone)
      met_.light += path.throughput * emitted_radiance(scene, vertex.point, vertex.wo);
    if (bounces == kMostBounces) return;
    if (!scene.media().empty()) vertex.media = media_at(scene, path.medium, hit.triangle, vertex.wo);
    // Colours of dispersive glass are taken together.
    RGB of_color(1.0f);
    resolve_material(scene, vertex, of_color, [] { return 0.5f; });
    if (!vertex.has(kSpecular)) return;
    const SmoothLobes lobes = smooth_lobes(vertex);
    met_.rough |= lobes.count == 0;
    if (lobes.count == 0 && glints_)
      add_gather_point(*glints_, vertex, path.throughput * share_, way.pixel, 0, 0, !scene.media().empty());
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
  std::vector<SkyRay>* const out_;
  GatherPoints* const glints_;
  const float share_;
  Met met_;
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

/// A picture whose pixels are divided.
struct DividedPicture {
  const Camera& camera;
  int width, height, across;
  PathMedium around;
};

/// Follows the ways of a pixel in front of the eye. @param way but for what belongs to one way
/// @param then called after each, with its number
template <typename Then>
void follow_pixel(const DividedPicture& picture, std::uint32_t pixel, WayTracer& tracer, SkyRay way, Then&& then) {
  const auto width = static_cast<std::uint32_t>(picture.width);
  const Vec2 corner{static_cast<float>(pixel % width), static_cast<float>(pixel / width)};
  const float step = 1 / static_cast<float>(picture.across);
  way.pixel = pixel;
  for (int i = 0; i < picture.across * picture.across; ++i) {
    const float u = (static_cast<float>(i % picture.across) + 0.5f) * step;
    const float v = (static_cast<float>(i / picture.across) + 0.5f) * step;
    const CameraRay ray =
        generate_ray(picture.camera, {corner.x + u, corner.y + v}, picture.width, picture.height, {0.5f, 0.5f});
    if (ray.is_blind()) continue;
    way.seen = in_view(picture.camera, ray.direction);
    if (!(way.seen.z > 0)) continue;
    SkyRay own = way;
    own.solid_angle *=
        static_cast<float>(solid_angle_density(picture.camera.kind, angular_plane(picture.camera.kind, way.seen)));
    PathState path;
    path.ray = {ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()};
    path.medium = picture.around;
    tracer.follow(path, own);
    then(static_cast<std::size_t>(i));
  }
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
  SkyRay way;
  way.solid_angle = static_cast<float>(double{window.right - window.left} * (window.top - window.bottom) /
                                       (double{1} * width * height * across * across));
  const DividedPicture picture{camera, width, height, across, camera_medium(tracer, camera)};
  parallel_for_each(of_row.size(), 1, [&](std::size_t y) {
    WayTracer tracer_of_row(tracer, &of_row[y], glints ? &glints_of_row[y] : nullptr, share);
    for (int x = 0; x < width; ++x)
      follow_pixel(picture,
                   static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(width) + static_cast<std::uint32_t>(x),
                   tracer_of_row, way, [](std::size_t) {});
    // Pictures of many pixels have no room for all.
    if (!straight) std::erase_if(of_row[y], [](const SkyRay& way) { return !way.bent; });
  });
  std::vector<SkyRay> out;
  for (const std::vector<SkyRay>& row : of_row) out.insert(out.end(), row.begin(), row.end());
  if (glints)
    for (const GatherPoints& row : glints_of_row) glints->append(row);
  return out;
}

std::vector<PixelDetail> light_within_pixels(const Tracer& tracer, const Camera& camera, int width, int height,
                                             std::span<const std::uint32_t> pixels) {
  std::vector<PixelDetail> all(pixels.size());
  std::vector<char> known(pixels.size(), 1);
  const DividedPicture picture{camera, width, height, PixelDetail::kAcross, camera_medium(tracer, camera)};
  constexpr std::size_t kPixelsAtOnce = 64;
  parallel_for_each(all.size(), kPixelsAtOnce, [&](std::size_t i) {
    WayTracer ways(tracer, nullptr);
    all[i].pixel = pixels[i];
    follow_pixel(picture, pixels[i], ways, {}, [&](std::size_t place) {
      const WayTracer::Met met = ways.take_met();
      known[i] &= static_cast<char>(!met.rough);
      all[i].luminance[place] = illuminance(met.light);
    });
  });
  std::vector<PixelDetail> out;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (known[i]) out.push_back(all[i]);
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
