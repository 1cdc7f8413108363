// Images of lights without size: where flat mirrors and panes show a lamp, and in which directions these and solid
// glass with flat faces show a sun.
//
// Light that a chain of smooth flat surfaces reflects seems to come from one place behind them, the image of the lamp,
// or from one direction. Solid glass sends parallel light on as parallel light. So a point sees a light by such
// surfaces in few directions, known beforehand: one ray in each finds it exactly, with sharp borders.
#pragma once
#include <cstdint>
#include <vector>

#include "scene/light.h"
#include "trace/tracer.h"
#include "transport/vertex.h"

namespace glowworm {

/// A light without size, and where points see it.
struct ImagedLight {
  Light light;
  /// Places, metres; those of a directional light are unit directions from the point. The first is the light itself; no
  /// two are the same().
  std::vector<Vec3> images;
  /// Metres or radians. Images closer than twice this are one: so no light counts twice.
  float tolerance = 0;

  bool is_far() const { return light.kind == LightKind::directional; }
  /// Whether two images differ by rounding alone.
  bool same(Vec3 a, Vec3 b) const { return length_squared(a - b) < tolerance * tolerance; }
  /// Whether one of the images is the same() as this one.
  bool has(Vec3 image) const;
  /// The unit direction of an image. @param from metres
  Vec3 direction(Vec3 image, Vec3 from) const { return is_far() ? image : normalize(image - from); }
};

/// The images that the larger smooth surfaces of a scene may show: by one reflection, by two, and those of suns
/// straight on through solid glass. A scene without smooth surfaces shows none.
class LightImages {
 public:
  /// For suns alone.
  explicit LightImages(const Scene& scene);
  /// For the scene's own lights: none if it has none with light.
  static LightImages of_lights(const Scene& scene);

  bool empty() const { return of_suns_.empty() && of_lamps_.empty(); }
  ImagedLight of(const Light& light) const;

 private:
  LightImages() = default;

  /// The points x of a mirror's plane have dot(x, normal) = offset, metres.
  struct Mirror {
    Vec3 normal;
    float offset = 0;
  };
  /// Mirrors in the order in which a ray from the point meets them.
  using Reflection = std::vector<Mirror>;
  static std::vector<Reflection> reflections(const Scene& scene, LightKind of, std::size_t most);

  std::vector<Reflection> of_suns_, of_lamps_;
};

/// A directional light of 1 W m^-2 across it. @param to_sun unit
Light sun_towards(Vec3 to_sun);

/// Whether all that a surface sends on at a vertex leaves by smooth_lobes(), so that rays to and from a sun follow the
/// same ways. Never for mixtures, which choose among their materials at random.
bool is_smooth(const Scene& scene, std::uint32_t triangle, const Vertex& vertex);

/// Irradiance across the light that arrives at a point from an image, W m^-2, after one bend at least, by is_smooth()
/// surfaces alone; that of lamps by reflection alone. Ways that lose all but a millionth are left out. Colours of
/// dispersive glass are taken together.
/// @param origin of the ray, metres @param medium around it @param image of `light` @param rays counts them
RGB light_of_image(const Tracer& tracer, Vec3 origin, PathMedium medium, const ImagedLight& light, Vec3 image,
                   std::uint64_t& rays);

}  // namespace glowworm
