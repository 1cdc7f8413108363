// Bytes in memory under the name of a file, for libraries that read files only.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace glowworm {

/// A file in memory that only this process sees. It is in no folder, so nothing is left of it, however the process
/// ends. Its bytes take memory twice, here and where they come from.
class MemoryFile {
 public:
  /// Copies the bytes. Throws MemoryError if the system does not give the file.
  explicit MemoryFile(std::span<const std::uint8_t> bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  /// A name by which this process can open the file as often as it likes.
  const std::string& path() const { return path_; }

 private:
  int descriptor_ = -1;
  std::string path_;
};

}  // namespace glowworm
