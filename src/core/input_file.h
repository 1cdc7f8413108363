// Input files.
#pragma once
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "core/memory_budget.h"

namespace glowworm {

/// Throws Error if `path` does not exist or is not a regular file: opening or reading a FIFO or a device could block
/// forever. Call it before you open a file by name.
void check_input_file(const std::string& path);

/// Records the names of all files that pass check_input_file() in this thread, including those read by
/// read_input_file(), while this object lives. Records may be nested: each gets all names.
class InputRecord {
 public:
  InputRecord();
  ~InputRecord();
  InputRecord(const InputRecord&) = delete;
  InputRecord& operator=(const InputRecord&) = delete;

  /// The recorded names, as given.
  const std::set<std::string>& names() const { return names_; }

 private:
  friend void record_input_file(const std::string& path);
  InputRecord* outer_;
  std::set<std::string> names_;
};

/// Adds a file that something else has read, such as another process, to this thread's records.
void record_input_file(const std::string& path);

/// Whether a file lies outside the folder of the file that names it. Follows symbolic links.
bool is_outside(const std::string& file, const std::string& named_by);

/// Reads a whole file. Throws Error as check_input_file() does, and if the file cannot be read or is larger than the
/// machine's memory.
std::string read_input_file(const std::string& path);

/// Reads a whole file within a budget. @param held grows by the file's size before memory is allocated, or throws
/// MemoryError
std::string read_input_file(const std::string& path, Reservation& held);
std::vector<std::uint8_t> read_input_bytes(const std::string& path, Reservation& held);

}  // namespace glowworm
