// Lights and the environment, as tables.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/rgb.h"
#include "core/transform.h"
#include "core/vec.h"
#include "scene/emission_profile.h"
#include "scene/intensity_table.h"
#include "scene/sky_model.h"
#include "scene/texture.h"

namespace glowworm {

/// The axes of a luminaire (IntensityTable): x to its right, y up, z along its aim. They are left-handed.
inline Frame luminaire_axes(Vec3 right, Vec3 aim) { return {right, cross(right, aim), aim}; }

/// Emission of a triangle from its front (and back): the same radiance in every direction, unless a profile scales it.
struct Emission {
  std::string name;
  ColorInput radiance{RGB(1.0f)};  ///< W sr^-1 m^-2
  bool two_sided = false;
  /// Factor on the radiance by direction. Its faces are the triangles of the emission, which follow one another.
  std::shared_ptr<const EmissionProfile> profile;
  Vec3 aim{0, 0, -1}, right{1, 0, 0};                    ///< profile: its z and x axes, unit
  std::uint32_t first_triangle = 0, triangle_count = 0;  ///< profile: the triangles
};

enum class LightKind : std::uint8_t { point, spot, directional, luminaire };

/// How a spot's intensity falls between its cones, where t runs with the cosine from 0 at the outer one to 1.
enum class SpotFalloff : std::uint8_t {
  smoothstep,  ///< t^2 (3 - 2 t), as in pbrt-v4
  quadratic,   ///< t^2, as in KHR_lights_punctual
  quartic,     ///< t^4, as in pbrt-v3
};

/// The luminous opening of a luminaire: a body around its place, with sizes along the axes of its table (m). A body
/// without size along an axis is a flat face. Fewer than two sizes: a point.
struct LuminousOpening {
  enum class Shape : std::uint8_t { box, cylinder, ellipsoid };
  Shape shape = Shape::box;
  Vec3 size{0, 0, 0};
  int axis = 2;  ///< cylinder: the axis along which it is straight

  /// Number of axes along which it has a size.
  int extent() const { return (size.x > 0) + (size.y > 0) + (size.z > 0); }
};

/// A light without extent.
struct Light {
  std::string name;
  LightKind kind = LightKind::point;
  RGB intensity{1.0f};       ///< point, spot: W sr^-1; directional: irradiance on a surface facing it, W m^-2;
                             ///< luminaire: W sr^-1 for a value of 1 in its table
  Vec3 position{0, 0, 0};    ///< all but directional: metres
  Vec3 direction{0, 0, -1};  ///< spot, directional: the direction in which light travels, unit; luminaire: its aim
  float cos_inner = 1;       ///< spot: full intensity within this angle of the direction,
  float cos_outer = 0;       ///< zero outside this angle; in between, according to `falloff`
  SpotFalloff falloff = SpotFalloff::smoothstep;
  Vec3 right{1, 0, 0};  ///< luminaire: where its table has x (IntensityTable), unit, across `direction`
  std::shared_ptr<const IntensityTable> table;  ///< luminaire: never null
  LuminousOpening opening;                      ///< luminaire: what the file says; the light itself is a point
};

enum class EnvironmentMapping : std::uint8_t {
  lat_long,    ///< u around, v from up to down
  equal_area,  ///< Clarberg's octahedral equal-area map, as pbrt-v4 uses it (u, v of the file, first row v = 0)
};

/// A division of the environment by direction into light sources of their own.
struct EnvironmentParts {
  std::uint32_t count = 1;
  /// The part of a unit direction in world space, towards the environment; less than `count`.
  std::function<std::uint32_t(Vec3)> part_of;
};

/// Light from infinitely far in all directions. Radiance is `scale` times the sky's or the image's, or
/// `scale` without either.
struct Environment {
  std::string name;
  RGB scale{1.0f};  ///< W sr^-1 m^-2
  int width = 0, height = 0;
  std::vector<RGB> pixels;  ///< row-major, first row on top
  EnvironmentMapping mapping = EnvironmentMapping::lat_long;
  /// To world space. In the image's space, lat_long has y up (u = 0.5 looks along -z, as in OpenEXR's envmaps) and
  /// equal_area has z up.
  Transform to_world;
  /// A formula in the space of lat_long. The image is then only what directions are sampled by.
  std::optional<SkyModel> sky;
  std::shared_ptr<const EnvironmentParts> parts;  ///< null: one light source
  bool stands_in = false;                         ///< shows a scene that has no light; it is none of the scene's own
};

}  // namespace glowworm
