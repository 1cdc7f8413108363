// glTF 2.0 files (.gltf, .glb).
#pragma once
#include <string>

#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads a glTF 2.0 file (Khronos, "glTF 2.0 Specification", 2021): meshes by the nodes of its scene, cameras, lights.
/// Photometric units of KHR_lights_punctual become radiometric by 683 lm/W, as Blender writes and reads them: lux to
/// W m^-2, candela to W sr^-1. Emissive colours are radiance in W sr^-1 m^-2, which is how Blender writes them too; a
/// surface emits from its front, or from both sides where it is doubleSided. Throws Error as load_scene() does.
SceneDescription load_gltf(const std::string& path, const ImportOptions& options);

struct GltfDocument;

/// The scene of a file that was read. Throws Error as load_gltf() does.
SceneDescription build_gltf_scene(const GltfDocument& document, const ImportOptions& options);

}  // namespace glowworm
