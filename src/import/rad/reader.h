// Scene files of Radiance (.rad).
#pragma once
#include <functional>
#include <string>
#include <string_view>

#include "core/coordinate_origin.h"
#include "core/memory_budget.h"
#include "import/import.h"
#include "import/notes.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads a scene description of Radiance (Ward and Shakespeare, "Rendering with Radiance", and the project's "Radiance
/// Reference Manual") with the files that it places by !xform. The commands xform, genbox and cat are evaluated here;
/// no command is ever run. Units are metres, z is up, and north is y. Sources of 180 degrees or more are the
/// environment, smaller ones lights without size. Notes name what is not supported. Throws Error with file and line for
/// what is wrong, for other commands, and for octrees and meshes.
/// @param origin is subtracted from all positions; read_near() finds it
SceneDescription load_rad(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin);

/// The text of a file that a line of `named_by` names; throws Error if it cannot be read. It sets the file's full name.
using RadFileReader = std::function<std::string(std::string& name, const std::string& named_by)>;

/// Reads a scene from memory. @param file for messages
/// @param budget limits memory while reading. Also throws MemoryError.
SceneDescription parse_rad(std::string_view text, const std::string& file, const RadFileReader& read_file,
                           NoteCounter& notes, MemoryBudget& budget, CoordinateOrigin& origin);

}  // namespace glowworm
