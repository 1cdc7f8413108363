// OBJ files with their materials.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/memory_budget.h"
#include "import/import.h"
#include "import/notes.h"
#include "import/phong.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads an OBJ file (Wavefront, "Advanced Visualizer Manual", appendix B1) and its material libraries. Faces of a
/// smoothing group without normals become smooth over edges of less than 60 degrees within their object and material.
/// Notes count what is not supported, material libraries that cannot be read, and materials used but not defined.
/// Throws Error with file, line and remedy for a face index out of range, a face of fewer than three corners, and a
/// vertex that is no number.
SceneDescription load_obj(const std::string& path, const ImportOptions& options);

/// What parse_obj() needs of the outside.
struct ObjFiles {
  /// The text of a material library; nothing where it cannot be read.
  std::function<std::optional<std::string>(const std::string& name)> library;
  std::function<std::shared_ptr<const TextureImage>(const PhongTexture&, const TextureOptions&)> texture;
};

/// The same from a text in memory. @param file for messages
/// @param budget that what is read is reserved in meanwhile. Throws MemoryError, too
SceneDescription parse_obj(std::string_view text, const std::string& file, const ObjFiles& files, NoteCounter& notes,
                           MemoryBudget& budget);

}  // namespace glowworm
