// Temporary files without a name.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace glowworm {

/// A file without a name: it disappears with the process, however that ends. Threads may use it at once, unless one
/// reads bytes that another writes.
class UnnamedFile {
 public:
  /// Makes the file in temporary_folder(). Throws Error if it cannot.
  UnnamedFile();
  ~UnnamedFile();
  UnnamedFile(const UnnamedFile&) = delete;
  UnnamedFile& operator=(const UnnamedFile&) = delete;

  /// Reads bytes from offset `first`. Throws Error if the disk fails or the file ends too early.
  void read(std::uint64_t first, std::span<std::byte> to) const;
  /// Writes bytes at offset `first`; the file grows as needed. Throws Error if the disk fails or is full.
  void write(std::uint64_t first, std::span<const std::byte> from);

 private:
  std::string folder_;
  int descriptor_ = -1;
};

/// Folder of unnamed files: TMPDIR, or else /tmp.
std::filesystem::path temporary_folder();

/// Maps a new unnamed file of so many zeros in temporary_folder() until munmap(). Its room on the disk is taken at
/// once. Throws Error if there is not enough.
void* map_unnamed_file(std::size_t bytes);

}  // namespace glowworm
