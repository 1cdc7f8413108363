// Whole files in memory, gzip or not, with bounds.
#pragma once
#include <cstdint>
#include <string>

#include "core/memory_budget.h"

namespace glowworm {

/// What a gzipped file may grow to beyond kMaxInflation times its size, which meshes and scenes stay far below.
inline constexpr std::uint64_t kSmallInflatedBytes = std::uint64_t{16} << 20;
inline constexpr std::uint64_t kMaxInflation = 200;

/// Reads a file; one that starts with gzip's magic bytes is inflated, whatever its name.
/// @param held grows by the bytes that are returned, before memory is taken for them
/// Throws Error with the file's name: missing, no regular file, unreadable, damaged, or inflated to more than a file of
/// its size should; and MemoryError.
std::string read_pbrt_file(const std::string& path, Reservation& held);

/// The path of a file that a scene names: absolute as it is, else under the main scene's folder, or where that does not
/// exist under the folder of the file that names it. A folder on the way may be a small file that holds a path, which
/// is what git leaves in place of a symbolic link where it makes none.
std::string resolve_pbrt_path(const std::string& name, const std::string& main_file, const std::string& naming_file);

}  // namespace glowworm
