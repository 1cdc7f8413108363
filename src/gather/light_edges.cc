#include "gather/light_edges.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "gather/camera_rays.h"
#include "transport/light_connection.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// Share of the brightest corner's light that the darkest one of an edge has at most.
constexpr float kEdge = 0.5f;

}  // namespace

BlockPixels LightEdges::find(int x0, int y0) {
  const Scene& scene = tracer_.scene();
  const int columns = std::min(CameraTask::kBlock, settings_.width - x0),
            rows = std::min(CameraTask::kBlock, settings_.height - y0);
  std::vector<Ray> corners;
  for (int y = 0; y <= rows; ++y)
    for (int x = 0; x <= columns; ++x)
      corners.push_back(ray_through(camera_, settings_, {static_cast<float>(x0 + x), static_cast<float>(y0 + y)}, {}));
  std::vector<Hit> hits(corners.size());
  tracer_.intersect(corners, hits, RayOrder::camera);
  rays += corners.size();
  std::vector<float> light(corners.size());
  std::vector<UnoccludedLight> suns;
  std::vector<std::size_t> lit;  // corners of these
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i].t_max < 0) continue;
    PathState path{corners[i]};
    const auto middle = [] { return 0.5f; };
    meet(
        scene, path, hits[i], true,
        [&](RGB emitted, std::uint32_t, const auto&) { light[i] += luminance(path.throughput * emitted); }, middle,
        [&](const Vertex& vertex) {
          if (!settings_.suns || !takes_light_samples(vertex.bsdf)) return false;
          UnoccludedLight sun =
              reflected_light(sample_directional(scene, vertex.point.position, middle()), vertex, kAllLobes, kAllLobes);
          sun.radiance *= path.throughput;
          if (is_black(sun.radiance)) return false;
          suns.push_back(sun);
          lit.push_back(i);
          return false;
        });
  }
  const std::vector<RGB> passed = passed_shares(tracer_, suns);
  for (std::size_t i = 0; i < passed.size(); ++i) light[lit[i]] += luminance(suns[i].radiance * passed[i]);
  shadow_rays += suns.size();

  BlockPixels edges;
  const auto stride = static_cast<std::size_t>(columns + 1);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x);
      const auto [least, most] = std::minmax({light[at], light[at + 1], light[at + stride], light[at + stride + 1]});
      edges[index_in_block(x, y)] = least < kEdge * most;
    }
  return edges;
}

}  // namespace glowworm
