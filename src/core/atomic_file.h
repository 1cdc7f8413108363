// Output files that appear whole or not at all.
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "core/error.h"
#include "core/temporary_files.h"

namespace glowworm {

/// Thrown when a write fails through no fault of the path: the disk is full or broken.
class DiskError : public Error {
 public:
  using Error::Error;
};

/// This path means standard output. Use "./-" for a file named "-".
inline constexpr std::string_view kStandardOutput = "-";

/// A file written under a temporary name beside its final one. commit() flushes the bytes to disk and renames the file.
/// Without commit(), or after a failure, the temporary file is removed and an older file of the final name is
/// unchanged. A device or a pipe (/dev/stdout) is written to directly; that fails if a pipe has no reader, or if its
/// reader takes nothing for ten seconds. Symbolic links are followed, even to a file that does not exist yet. A file
/// that replaces another keeps its permissions, except setuid, setgid and sticky bits.
class AtomicFile {
 public:
  /// Creates the temporary file. Throws Error if the folder is missing or not writable, or if `path` is a folder or a
  /// write-protected file. Throws DiskError if the disk is full or broken.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends bytes. If the write fails, removes the temporary file and throws DiskError.
  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }

  /// Flushes to disk (fsync) and renames to the final name. Throws DiskError if either fails. Call it once.
  void commit();

  /// The final name, as given.
  const std::string& path() const { return path_; }

 private:
  void discard() noexcept;
  [[noreturn]] void fail(const std::string& what, int error_number);

  std::string path_;       // as given
  std::string target_;     // with symbolic links followed
  std::string temporary_;  // empty if the target is written to directly
  std::unique_ptr<TemporaryName> registered_;
  int descriptor_ = -1;
};

/// Writes a whole file at once, or throws Error and leaves any older file unchanged.
void write_file(const std::string& path, std::string_view content);

/// The file that AtomicFile would write to. Two paths have equal identities if they name one inode or would create the
/// same file. Empty for a device, because several outputs may share it.
std::string output_identity(const std::string& path);

}  // namespace glowworm
