#include "maps/image_light.h"

#include <array>
#include <map>

#include "core/parallel.h"
#include "transport/medium.h"

namespace glowworm {

namespace {

/// A light of the scene and its images.
struct SourceImages {
  std::uint32_t source = 0;  ///< counted as in Scene::light_power()
  ImagedLight light;
};

std::vector<SourceImages> images_of_lights(const Scene& scene, const LightImages& images) {
  std::vector<SourceImages> out;
  for (std::size_t i = 0; i < scene.lights().size(); ++i) {
    if (is_black(scene.lights()[i].intensity)) continue;
    const auto source = static_cast<std::uint32_t>(scene.emissive_triangles().size() + i);
    out.push_back({source, images.of(scene.lights()[i])});
  }
  return out;
}

/// Points at one place that face one way, and their light by images.
struct SamePoints {
  std::vector<std::size_t> points;
  std::vector<RGB> light;
};

std::vector<SamePoints> same_points(std::span<const AirPoint> points) {
  std::map<std::array<float, 6>, std::size_t> place;
  std::vector<SamePoints> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p = points[i].position, n = points[i].normal;
    const auto [found, added] = place.try_emplace({p.x, p.y, p.z, n.x, n.y, n.z}, out.size());
    if (added) out.emplace_back();
    out[found->second].points.push_back(i);
  }
  return out;
}

}  // namespace

void add_image_light(const Tracer& tracer, const LightImages& images, std::span<const AirPoint> points,
                     SlotRadiance& radiance, std::vector<RGB>& part, Statistics& statistics) {
  if (images.empty()) return;
  const Scene& scene = tracer.scene();
  const std::vector<SourceImages> sources = images_of_lights(scene, images);
  std::vector<SamePoints> places = same_points(points);
  parallel_for_each(places.size(), 1, [&](std::size_t i) {
    const AirPoint& point = points[places[i].points.front()];
    const PathMedium medium =
        scene.media().empty() ? PathMedium{} : medium_at_start(tracer, point.position, point.normal);
    std::uint64_t rays = 0;
    for (const SourceImages& source : sources) {
      RGB found(0.0f);
      for (const Vec3 image : source.light.images)
        if (const float cosine = dot(source.light.direction(image, point.position), point.normal); cosine > 0)
          found += light_of_image(tracer, point.position, medium, source.light, image, rays) * cosine;
      places[i].light.push_back(found);
    }
    statistics.add(Counter::occlusion_rays, rays);
  });
  for (const SamePoints& same : places)
    for (std::size_t k = 0; k < sources.size(); ++k)
      if (!is_black(same.light[k]))
        for (const std::size_t point : same.points)
          radiance.add(part, points[point].slot, same.light[k], sources[k].source);
}

}  // namespace glowworm
