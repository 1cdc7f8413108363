// The formats that are read by Assimp, in a process of its own.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// What the process that reads a file may use.
struct AssimpLimits {
  std::uint64_t memory_bytes = 0;  ///< of address space, and of what it hands over; 0: the limit of the budget for
                                   ///< loading, and no more than half of the machine's memory
  unsigned cpu_seconds = 0;        ///< of the processor; 0: a minute, and two seconds for each MiB of the file
  unsigned clock_seconds = 0;      ///< by the clock; 0: ten times as many, since machines are shared
};

/// Reads a file by the program glowworm-assimp. Throws Error with the file, its format and the cause where that program
/// crashes, meets a limit, or hands over what is not sound; Cancelled as check_cancelled() does; else as load_scene().
SceneDescription load_assimp(const std::string& path, const ImportOptions& options, const AssimpLimits& limits = {});

/// The scene of what the program handed over. Throws Error where that is not sound, and MemoryError.
SceneDescription build_assimp_scene(std::string_view bytes, const std::string& path, const ImportOptions& options);

/// Whether files of that extension (".fbx"; lower case, with the dot) are left to Assimp: formats that it reads well.
bool assimp_reads(const std::string& extension);

}  // namespace glowworm
