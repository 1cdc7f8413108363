// Decompresses geometry of glTF files: EXT_meshopt_compression and KHR_draco_mesh_compression.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tinygltf {
struct Primitive;
}

namespace glowworm {

struct GltfDocument;
class Reservation;

/// Decodes all compressed buffer views of a document (EXT_meshopt_compression, by meshoptimizer) into its
/// decoded_views, resized to one for each buffer view. Throws Error if one is damaged.
void decode_meshopt_views(GltfDocument& document);

/// A primitive decoded by Draco: attributes, and vertex indices, three per triangle.
struct DracoPrimitive {
  struct Attribute {
    int components = 0;
    std::vector<float> values;  ///< `components` per vertex; integers are normalised if the file says so
  };
  std::map<std::string, Attribute> attributes;  ///< by glTF name: POSITION, NORMAL, TEXCOORD_0, ...
  std::vector<std::uint32_t> indices;
  std::size_t vertex_count = 0;
};

/// Whether a primitive is compressed by Draco.
bool is_draco(const tinygltf::Primitive& primitive);

/// The attributes of a primitive that is compressed by Draco; none if it is not. The document's reservation grows.
/// Throws Error as decode_draco() does.
std::optional<DracoPrimitive> draco_attributes(const GltfDocument& document, int mesh, std::size_t primitive);

/// Decodes a primitive compressed by Draco (KHR_draco_mesh_compression). Throws Error, which names `where`, if it is
/// damaged. @param held grows by the memory of the result, or throws MemoryError
DracoPrimitive decode_draco(const GltfDocument& document, const tinygltf::Primitive& primitive,
                            const std::string& where, Reservation& held);

}  // namespace glowworm
