// Compressed geometry of glTF files: EXT_meshopt_compression and KHR_draco_mesh_compression.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace tinygltf {
struct Primitive;
}

namespace glowworm {

struct GltfDocument;

/// Decodes every compressed buffer view of a document into its decoded_views, which it resizes to one for each buffer
/// view (EXT_meshopt_compression, "Ratified Khronos extension", by meshoptimizer). Throws Error where one is broken.
void decode_meshopt_views(GltfDocument& document);

/// A primitive that Draco decoded: numbers of each attribute, and vertex indices, three a triangle.
struct DracoPrimitive {
  struct Attribute {
    int components = 0;
    std::vector<float> values;  ///< `components` a vertex; integers are normalised where the file says so
  };
  std::map<std::string, Attribute> attributes;  ///< by glTF's names: POSITION, NORMAL, TEXCOORD_0, ...
  std::vector<std::uint32_t> indices;
  std::size_t vertex_count = 0;
};

/// Whether a primitive is compressed with Draco.
bool is_draco(const tinygltf::Primitive& primitive);

/// Decodes a primitive compressed with Draco (KHR_draco_mesh_compression). Throws Error, naming `where`, where it is
/// broken.
DracoPrimitive decode_draco(const GltfDocument& document, const tinygltf::Primitive& primitive,
                            const std::string& where);

}  // namespace glowworm
