// Imports scene formats by Assimp, in a separate process.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "core/coordinate_origin.h"
#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Limits of the process that reads a file.
struct AssimpLimits {
  /// Address space, and size of the result; 0: a GiB plus a thousand bytes for each of the file, but at most the limit
  /// of the loading budget and half of the machine's memory.
  std::uint64_t memory_bytes = 0;
  unsigned cpu_seconds = 0;    ///< processor time; 0: a minute plus two seconds per MiB of the file
  unsigned clock_seconds = 0;  ///< wall time; 0: ten times cpu_seconds, because machines are shared
};

/// Reads a file by the program glowworm-assimp. Throws Error with the file, its format and the cause if that program
/// crashes, reaches a limit or returns invalid data; Cancelled as check_cancelled() does; otherwise as load_scene().
/// @param origin is subtracted from all positions; read_near() finds it
SceneDescription load_assimp(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin,
                             const AssimpLimits& limits = {});

/// Builds the scene from the program's output. Throws Error if that is invalid, and MemoryError.
SceneDescription build_assimp_scene(std::string_view bytes, const std::string& path, const ImportOptions& options,
                                    CoordinateOrigin& origin);

/// Whether files with this extension (".fbx"; lower case, with the dot) are read by Assimp: formats that it reads well.
bool assimp_reads(const std::string& extension);

}  // namespace glowworm
