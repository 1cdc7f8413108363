// Converts meshes of glTF files to triangles.
#pragma once
#include <string>
#include <vector>

#include "core/transform.h"
#include "import/notes.h"
#include "scene/geometry.h"

namespace tinygltf {
struct Primitive;
}

namespace glowworm {

struct GltfDocument;

/// The sets of texture coordinates to read for a mesh; -1: none.
struct GltfUvSets {
  int first = 0, second = -1;
};

/// Reads a primitive in its mesh's space, as Geometry without materials: triangles, strips and fans; indexed or not;
/// plain, sparse, quantised or compressed. Vertices keep the file's order. Texture coordinates have v upwards. Colours
/// are present only if one is not white. Notes count parts that are left out.
/// @param where name of the primitive for messages: "meshes[3].primitives[0]"
/// Throws Error if an index is out of range or attributes differ in length.
Geometry read_gltf_primitive(const GltfDocument& document, const tinygltf::Primitive& primitive, GltfUvSets uv_sets,
                             const std::string& where, NoteCounter& notes);

/// The same for a primitive by its number, without texture coordinates.
Geometry read_gltf_primitive(const GltfDocument& document, int mesh, std::size_t primitive);

/// The deformation of a mesh by its node.
struct GltfDeformation {
  std::vector<float> weights;     ///< of morph targets
  std::vector<Transform> joints;  ///< from the mesh to the world; empty if the mesh has no skin
};

/// Applies morph targets, then joints, to a mesh from read_gltf_primitive() (glTF 2.0, sections 3.7.2.2 and 3.7.3.3).
/// Joints transform the mesh to world space. Throws Error if attributes differ in length or refer to a joint that does
/// not exist.
void deform_gltf_primitive(const GltfDocument& document, const tinygltf::Primitive& primitive,
                           const GltfDeformation& deformation, const std::string& where, Geometry& mesh);

}  // namespace glowworm
