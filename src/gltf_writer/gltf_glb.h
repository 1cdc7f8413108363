// A glTF file with its baked light.
#pragma once
#include <string>

#include "gltf_writer/scene_glb.h"

namespace glowworm {

/// The file that notes.gltf names, with the light of a layout: glb_of_scene() for scenes from glTF files.
std::string glb_of_gltf(const BakeLayout& layout, const EncodedLight& light, BakeFormat format, const BakeNotes& notes);

}  // namespace glowworm
