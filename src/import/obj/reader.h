// OBJ files with their materials.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "core/coordinate_origin.h"
#include "core/memory_budget.h"
#include "import/import.h"
#include "import/notes.h"
#include "import/phong.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads an OBJ file (Wavefront, "Advanced Visualizer Manual", appendix B1) and its material libraries. Smoothing
/// groups whose faces have no normals become smooth across edges of less than 60 degrees, within one object,
/// whatever its materials and groups. Notes count unsupported features, faces with fewer than three corners, material
/// libraries that cannot be read, and undefined materials. Throws Error with file, line and remedy for a face index out
/// of range or an invalid vertex.
/// @param origin is subtracted from all positions; read_near() finds it
SceneDescription load_obj(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin);

/// Access to other files for parse_obj().
struct ObjFiles {
  /// The text of a material library; empty if it cannot be read.
  std::function<std::optional<std::string>(const std::string& name)> library;
  PhongTextureLoader texture;
};

/// Reads an OBJ file from memory. @param file for messages
/// @param budget limits memory while reading. Also throws MemoryError.
SceneDescription parse_obj(std::string_view text, const std::string& file, const ObjFiles& files, NoteCounter& notes,
                           MemoryBudget& budget, CoordinateOrigin& origin);

}  // namespace glowworm
