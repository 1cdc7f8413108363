// Conditions on a scene's description, checked once so that later code can rely on them.
#pragma once
#include <vector>

#include "scene/scene.h"

namespace glowworm {

/// Maximum coordinate and length of a scene, and minimum diagonal of the box around it, in metres. Embree multiplies
/// three lengths of triangles: beyond 7e12 m these products overflow, and in fine meshes of smaller scenes they vanish.
/// Embree gives no barycentric coordinates (0, 0) where four times a triangle's area, seen along the ray, is below
/// 1e-18 m^2: triangles with sides of half a nanometre show the normal and texture of their first vertex.
inline constexpr float kMaxCoordinate = 1e12f, kMinSceneSize = 1e-7f;
/// Maximum intensity or irradiance of a light, so that sums over lights and samples stay finite. kMaxRadiance bounds
/// radiance.
inline constexpr float kMaxLight = 1e30f;

/// The work of one lookup of a texture node.
struct TextureCost {
  double nodes = 1;  ///< number of nodes evaluated
  int levels = 1;    ///< longest chain of nodes
  /// Whether scenes may hold the node. Lookups of others could hang or overflow the stack.
  bool is_allowed() const;
};
/// Measures the nodes after those that `costs` covers already, and appends their costs. Children stand before their
/// parents.
void measure_textures(const std::vector<TextureNode>& textures, std::vector<TextureCost>& costs);

/// Whether a point is finite and within kMaxCoordinate.
bool is_within_bounds(Vec3 p);
/// Throws Error, naming `what` and the value, if a point is not within bounds.
void check_within_bounds(Vec3 p, const std::string& what);

/// Throws Error if a description has an index out of range, arrays of unequal length, a vertex, camera or lens that is
/// not finite or too far out, a medium whose numbers are out of range, less than the minimum size, a light that is
/// negative or too bright, textures or mixed materials that refer to themselves, or no triangle.
void check_description(const SceneDescription& description);
/// The same for only lights and cameras, as in a SceneEdit.
void check_lights(const SceneDescription& description);
/// Throws Error if the numbers of a medium are out of range. @param size of the scene, metres
void check_medium(const Medium& medium, float size);
/// Throws Error if even the brightest light is too dim for pictures, but not black. @param radius of the scene, metres
void check_dimness(const SceneDescription& description, float radius);
void check_cameras(const SceneDescription& description);

}  // namespace glowworm
