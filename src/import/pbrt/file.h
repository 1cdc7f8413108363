// Whole files in memory, gzip or not, with bounds.
#pragma once
#include <cstdint>
#include <string>

namespace glowworm {

/// What a gzipped file may grow to: about 4 GiB, far over what scenes have, far under what a crafted one could ask for.
inline constexpr std::uint64_t kMaxInflatedBytes = std::uint64_t{4} << 30;

/// Reads a file; one that starts with gzip's magic bytes is inflated, whatever its name.
/// Throws Error with the file's name: missing, no regular file, unreadable, damaged, or larger than max_inflated_bytes
/// when inflated.
std::string read_pbrt_file(const std::string& path, std::uint64_t max_inflated_bytes = kMaxInflatedBytes);

/// The path of a file that a scene names: absolute as it is, else under the main scene's folder, or where that does not
/// exist under the folder of the file that names it. A folder on the way may be a small file that holds a path, which
/// is what git leaves in place of a symbolic link where it makes none.
std::string resolve_pbrt_path(const std::string& name, const std::string& main_file, const std::string& naming_file);

}  // namespace glowworm
