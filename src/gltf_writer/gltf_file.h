// glTF files as GLB files to change.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "gltf_writer/glb.h"
#include "import/gltf/document.h"

namespace glowworm {

/// The file of a document with all its buffers and image files inside. Images that are missing, or whose formats glTF
/// does not have, stay names of files.
/// @param allow_outside whether that includes image files outside of the document's folder
/// @param folder        of the new file, to which names of images are relative
GlbFile glb_of_document(const GltfDocument& document, nlohmann::json whole, bool allow_outside,
                        const std::string& folder);

}  // namespace glowworm
