// Reads whole files into memory, gzipped or not, with size limits.
#pragma once
#include <cstdint>
#include <string>

#include "core/memory_budget.h"

namespace glowworm {

/// A gzipped file may inflate to kMaxInflation times its size plus this many bytes. Meshes and scenes stay far below.
inline constexpr std::uint64_t kSmallInflatedBytes = std::uint64_t{16} << 20;
inline constexpr std::uint64_t kMaxInflation = 200;

/// Reads a file. A file that starts with gzip's magic bytes is inflated, whatever its name.
/// @param held grows by the bytes returned, before memory is allocated
/// Throws Error with the file's name if it is missing, not a regular file, unreadable or damaged, or if it inflates
/// beyond the limit; and MemoryError.
std::string read_pbrt_file(const std::string& path, Reservation& held);

/// Resolves a path in a scene file. Absolute paths are unchanged. Others are relative to the main scene's folder or, if
/// there is no such file, to the folder of the file that contains the path. Components may be small files that contain
/// a path: git writes such files where it cannot create symbolic links.
std::string resolve_pbrt_path(const std::string& name, const std::string& main_file, const std::string& naming_file);

}  // namespace glowworm
