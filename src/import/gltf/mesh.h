// Meshes of glTF files to triangles.
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

/// The sets of texture coordinates that a mesh is read with; -1: none.
struct GltfUvSets {
  int first = 0, second = -1;
};

/// Reads a primitive in its mesh's own space, as Geometry without materials: triangles, strips and fans; indexed or
/// not; plain, sparse, quantised or compressed. Vertices are those of the file, in their order. Texture coordinates
/// come out with v upwards; colours only where one is not white. What is left out is counted in the notes.
/// @param where  names the primitive in messages: "meshes[3].primitives[0]"
/// Throws Error where an index is out of range or attributes differ in length.
Geometry read_gltf_primitive(const GltfDocument& document, const tinygltf::Primitive& primitive, GltfUvSets uv_sets,
                             const std::string& where, NoteCounter& notes);

/// What a node does to the vertices of its mesh.
struct GltfDeformation {
  std::vector<float> weights;     ///< of morph targets
  std::vector<Transform> joints;  ///< from the mesh to the world; not empty where the mesh has a skin
};

/// Applies morph targets, then joints, to a mesh that read_gltf_primitive() gave (glTF 2.0, sections 3.7.2.2 and
/// 3.7.3.3). With joints the mesh is in world space after it. Throws Error where attributes differ in length or name a
/// joint that is not there.
void deform_gltf_primitive(const GltfDocument& document, const tinygltf::Primitive& primitive,
                           const GltfDeformation& deformation, const std::string& where, Geometry& mesh);

}  // namespace glowworm
