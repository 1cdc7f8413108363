// The scene that the program glowworm-assimp passes to its parent process, and its encoding in bytes.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/transform_double.h"
#include "core/vec.h"
#include "import/phong.h"

namespace glowworm {

/// A mesh in its own space.
struct ForeignMesh {
  std::string name;
  std::uint32_t material = 0;
  bool has_points_or_lines = false, has_bones = false, has_colors = false;
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< one per vertex, or empty
  std::vector<Vec2> uvs;      ///< one per vertex, or empty
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A mesh placed in the world.
struct ForeignInstance {
  std::uint32_t mesh = 0;
  TransformDouble to_world;
};

struct ForeignCamera {
  std::string name;
  TransformDouble to_world;
  Vec3 position, look_at, up;
  float aspect = 0;              ///< width over height; 0: unknown
  float horizontal_fov = 0;      ///< half the angle, radians
  float orthographic_width = 0;  ///< half the width; 0 for a perspective camera
};

enum class ForeignLightKind : std::uint8_t { point, spot, directional, other };

struct ForeignLight {
  std::string name;
  TransformDouble to_world;
  ForeignLightKind kind = ForeignLightKind::other;
  RGB intensity;
  Vec3 position, direction;
  float inner_angle = 0, outer_angle = 0;  ///< full angle of the cone, radians
};

/// The content of a file as read by Assimp.
struct ForeignScene {
  std::vector<std::string> files;     ///< all files that were read, as named
  std::vector<std::string> embedded;  ///< image files inside the file; empty if the format is unknown
  std::vector<PhongMaterial> materials;
  std::vector<ForeignMesh> meshes;
  std::vector<ForeignInstance> instances;
  std::vector<ForeignCamera> cameras;
  std::vector<ForeignLight> lights;
  std::uint32_t animations = 0;
};

/// Encodes a scene and passes its bytes to `write`, piece by piece.
void write_foreign_scene(const ForeignScene& scene, const std::function<void(const void*, std::size_t)>& write);

/// Decodes a scene. Any bytes give either a valid scene or an Error: all counts match the data, all indices are within
/// their tables, and enumerators are known. Memory is proportional to the number of bytes.
/// @param file for messages
ForeignScene read_foreign_scene(std::string_view bytes, const std::string& file);

}  // namespace glowworm
