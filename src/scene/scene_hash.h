// Hashes of the scene data that pictures depend on.
#pragma once
#include <cstdint>

#include "scene/scene.h"

namespace glowworm {

/// Hashes of the parts of a scene. Names count only if they are looked up, so renaming a part does not change its hash.
struct SceneHash {
  std::uint64_t geometry;   ///< positions, normals, texture coordinates, and the material of each triangle
  std::uint64_t materials;  ///< with their textures, to the texel
  std::uint64_t lights;     ///< with emissions and environment
  std::uint64_t camera;
};

/// Of all that a camera's rays depend on.
std::uint64_t hash_camera(const Camera& camera);

/// Of materials and media, with images by TextureImage::identity(), while the scene exists. Reads no texels.
std::uint64_t hash_look(const Scene& scene);

/// Reads all tables and texels, on all threads: some seconds for gigabytes of textures.
SceneHash hash_scene(const Scene& scene, const Camera& camera);

}  // namespace glowworm
