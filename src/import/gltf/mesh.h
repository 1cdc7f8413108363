// Meshes of glTF files to triangles.
#pragma once
#include <optional>
#include <string>

#include "core/rgb.h"
#include "import/notes.h"
#include "scene/geometry.h"

namespace tinygltf {
struct Primitive;
}

namespace glowworm {

struct GltfDocument;

/// One primitive in its mesh's own space, as Geometry without materials.
struct GltfPrimitive {
  Geometry mesh;
  /// The colour that all its vertices have, where the file gives one and it is not white.
  std::optional<RGB> vertex_color;
};

/// Reads a primitive: triangles, strips and fans; indexed or not; plain, sparse, quantised or compressed. Texture
/// coordinates come out with v upwards. What is left out is counted in the notes.
/// @param uv_set which set of texture coordinates to take
/// @param where  names the primitive in messages: "meshes[3].primitives[0]"
/// Throws Error where an index is out of range or attributes differ in length.
GltfPrimitive read_gltf_primitive(const GltfDocument& document, const tinygltf::Primitive& primitive, int uv_set,
                                  const std::string& where, NoteCounter& notes);

}  // namespace glowworm
