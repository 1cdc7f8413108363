// Files that are read.
#pragma once
#include <string>

namespace glowworm {

/// Throws Error where `path` is not there or is not a regular file: to open or read a FIFO or a device may block for
/// ever. Call it before a file is opened by its name.
void check_input_file(const std::string& path);

/// Reads a whole file. Throws Error as check_input_file() does, and where the file cannot be read or is larger than the
/// machine's memory.
std::string read_input_file(const std::string& path);

}  // namespace glowworm
