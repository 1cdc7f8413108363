// glTF 2.0 files (.gltf, .glb).
#pragma once
#include <string>

#include "core/coordinate_origin.h"
#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads a glTF 2.0 file (Khronos, "glTF 2.0 Specification", 2021): meshes of the nodes in its scene, cameras and
/// lights. Photometric units of KHR_lights_punctual are converted to radiometric units by 179 lm/W: lux to
/// W m^-2, candela to W sr^-1. Emissive colours are radiance in W sr^-1 m^-2, as in Blender. A surface emits
/// from its front, or from both sides if it is doubleSided. Throws Error as load_scene() does.
/// @param origin is subtracted from all positions; read_near() finds it
SceneDescription load_gltf(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin);

struct GltfDocument;
class GltfMeshes;

/// Builds the scene of a document. Throws Error as load_gltf() does. @param meshes of the document; null: read for this
SceneDescription build_gltf_scene(const GltfDocument& document, const ImportOptions& options, CoordinateOrigin& origin,
                                  GltfMeshes* meshes = nullptr);

}  // namespace glowworm
