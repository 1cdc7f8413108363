// Files that are read.
#pragma once
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "core/memory_budget.h"

namespace glowworm {

/// Throws Error where `path` is not there or is not a regular file: to open or read a FIFO or a device may block for
/// ever. Call it before a file is opened by its name.
void check_input_file(const std::string& path);

/// Remembers, while it lives, the names of all files that pass check_input_file() in any thread, also on their way into
/// read_input_file(). There may be one at a time; a second one remembers nothing.
class InputRecord {
 public:
  InputRecord();
  ~InputRecord();
  InputRecord(const InputRecord&) = delete;
  InputRecord& operator=(const InputRecord&) = delete;

  /// The names so far, as they were given.
  std::set<std::string> names() const;
};

/// Reads a whole file. Throws Error as check_input_file() does, and where the file cannot be read or is larger than the
/// machine's memory.
std::string read_input_file(const std::string& path);

/// The same within a budget. @param held grows by the file's size before memory is taken for it, or throws MemoryError
std::string read_input_file(const std::string& path, Reservation& held);
std::vector<std::uint8_t> read_input_bytes(const std::string& path, Reservation& held);

}  // namespace glowworm
