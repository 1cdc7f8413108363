// The scene that the program glowworm-assimp hands over to the one that started it, and its form as bytes.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/transform.h"
#include "core/vec.h"
#include "import/phong.h"

namespace glowworm {

/// A mesh in its own space.
struct ForeignMesh {
  std::string name;
  std::uint32_t material = 0;
  bool has_points_or_lines = false, has_bones = false, has_colors = false;
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< one a vertex, or empty
  std::vector<Vec2> uvs;      ///< one a vertex, or empty
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A mesh at a place of the world.
struct ForeignInstance {
  std::uint32_t mesh = 0;
  Transform to_world;
};

struct ForeignCamera {
  std::string name;
  Transform to_world;
  Vec3 position, look_at, up;
  float aspect = 0;              ///< width over height; 0: not known
  float horizontal_fov = 0;      ///< half of the angle, radians
  float orthographic_width = 0;  ///< half of it; 0 for a perspective camera
};

enum class ForeignLightKind : std::uint8_t { point, spot, directional, other };

struct ForeignLight {
  std::string name;
  Transform to_world;
  ForeignLightKind kind = ForeignLightKind::other;
  RGB intensity;
  Vec3 position, direction;
  float inner_angle = 0, outer_angle = 0;  ///< of the whole cone, radians
};

/// What a file of one of Assimp's formats holds, as Assimp gives it.
struct ForeignScene {
  std::vector<std::string> embedded;  ///< image files inside of the file; empty where they are in no known format
  std::vector<PhongMaterial> materials;
  std::vector<ForeignMesh> meshes;
  std::vector<ForeignInstance> instances;
  std::vector<ForeignCamera> cameras;
  std::vector<ForeignLight> lights;
  std::uint32_t animations = 0;
};

/// Exit statuses of glowworm-assimp beside 0.
enum class ForeignExit : int {
  refused = 1,        ///< the file cannot be read; what Assimp says of it was handed over in place of the scene
  out_of_memory = 2,  ///< the limit on memory was met
  misused = 3         ///< by the arguments it was started with
};

/// Gives the bytes of a scene to `write`, piece by piece.
void write_foreign_scene(const ForeignScene& scene, const std::function<void(const void*, std::size_t)>& write);

/// The scene of these bytes. Whatever they are, the scene is sound: all counts are those of what follows, all indices
/// are within their tables, and enumerators are known. Memory stays in proportion to the number of bytes. Throws Error
/// where that cannot be. @param file for messages
ForeignScene read_foreign_scene(std::string_view bytes, const std::string& file);

}  // namespace glowworm
