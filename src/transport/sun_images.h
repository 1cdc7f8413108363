// Images of suns: directions in which flat mirrors and panes, and solid glass with flat faces, show a directional
// light.
//
// A chain of smooth flat surfaces sends parallel light on as parallel light, in a direction that depends on their
// normals alone. So a point sees the sun by such surfaces in few directions, known beforehand: one ray in each finds
// the light exactly, with sharp borders.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "trace/tracer.h"
#include "transport/vertex.h"

namespace glowworm {

/// The images that the larger smooth surfaces of a scene may show: by one reflection, by two, and straight on through
/// solid glass. A scene without smooth surfaces shows none.
class SunImages {
 public:
  explicit SunImages(const Scene& scene);
  /// For the scene's own directional lights: none if it has none with light.
  static SunImages of_lights(const Scene& scene);

  bool empty() const { return reflections_.empty(); }
  /// Unit, from a point that sees the images. The first is straight towards the sun; no two are the same().
  /// @param to_sun unit
  std::vector<Vec3> of(Vec3 to_sun) const;
  /// Whether two unit directions differ by rounding alone.
  static bool same(Vec3 a, Vec3 b) { return squared_distance(a, b) < kTolerance * kTolerance; }

 private:
  SunImages() = default;

  /// Radians. Images that are closer than twice this are one: so no light counts twice.
  static constexpr float kTolerance = 1e-3f;
  static float squared_distance(Vec3 a, Vec3 b) { return dot(a - b, a - b); }

  /// Normals of the mirrors, in the order in which a ray from the point meets them.
  using Reflection = std::vector<Vec3>;
  std::vector<Reflection> reflections_;
};

/// Whether all that a surface sends on at a vertex leaves by smooth_lobes(), so that rays to and from a sun follow the
/// same ways. Never for mixtures, which choose among their materials at random.
bool is_smooth(const Scene& scene, std::uint32_t triangle, const Vertex& vertex);

/// Irradiance across the light of a sun that arrives at a point along `direction` after one bend at least, by
/// is_smooth() surfaces alone, over the sun's own; ways of less than a millionth are left out. Colours of dispersive
/// glass are taken together.
/// @param medium around the point @param direction unit, from the point @param to_sun unit @param rays counts them
RGB light_of_image(const Tracer& tracer, Vec3 origin, PathMedium medium, Vec3 direction, Vec3 to_sun,
                   std::uint64_t& rays);

}  // namespace glowworm
