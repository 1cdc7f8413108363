// Bytes on disk that never outlive the program.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace glowworm {

/// A file that has no name from the moment it is open: it is gone with the process, however that ends. Thread-safe
/// where no byte is read while it is written.
class UnnamedFile {
 public:
  /// @param folder where it takes its room; empty: that of the environment (TMPDIR, else /tmp)
  /// Throws Error where no file can be made there.
  explicit UnnamedFile(const std::string& folder = {});
  ~UnnamedFile();
  UnnamedFile(const UnnamedFile&) = delete;
  UnnamedFile& operator=(const UnnamedFile&) = delete;

  /// Copies bytes out, from byte `first` of the file on. Throws Error where the disk fails or the file ends before.
  void read(std::uint64_t first, std::span<std::byte> to) const;
  /// Copies bytes in; the file grows where it must. Throws Error where the disk fails or is full.
  void write(std::uint64_t first, std::span<const std::byte> from);

 private:
  std::string folder_;
  int descriptor_ = -1;
};

}  // namespace glowworm
