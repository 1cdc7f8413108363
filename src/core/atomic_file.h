// Output files that appear whole or not at all.
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "core/error.h"
#include "core/temporary_files.h"

namespace glowworm {

/// Thrown where a file cannot be written although nothing is wrong with its name: the disk is full, or fails.
class DiskError : public Error {
 public:
  using Error::Error;
};

/// The path that stands for standard output; "./-" is a file of that name.
inline constexpr std::string_view kStandardOutput = "-";

/// A file being written under a temporary name beside its final one. commit() brings the bytes to the disk and gives
/// the file its name; without commit(), or after a failure, nothing is left and an older file of that name stays as
/// it was. A path that is a device or a pipe (/dev/stdout) is written to directly, and fails
/// where a pipe has no reader or its reader takes nothing for ten seconds. A symbolic link is followed, to a
/// file that does not exist yet, too. A file that replaces another one keeps its permissions, without setuid, setgid
/// and sticky bits.
class AtomicFile {
 public:
  /// Creates the temporary file; throws Error where the folder is missing or not writable, or where `path` is a folder
  /// or a write-protected file, and DiskError where the disk is full or fails.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends bytes; throws DiskError where the write fails, and then the temporary is gone.
  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }

  /// Flushes to the disk (fsync) and renames to the final name; throws DiskError where either fails. To be called once.
  void commit();

  /// The final name, as it was given.
  const std::string& path() const { return path_; }

 private:
  void discard() noexcept;
  [[noreturn]] void fail(const std::string& what, int error_number);

  std::string path_;       // as given
  std::string target_;     // with symbolic links followed
  std::string temporary_;  // empty where the target is written to directly
  std::unique_ptr<TemporaryName> registered_;
  int descriptor_ = -1;
};

/// Writes a whole file at once, or throws Error and leaves what was there before.
void write_file(const std::string& path, std::string_view content);

/// The file that AtomicFile would write to: equal for two paths where both name one inode, or would be created under
/// one name. Empty for a device, which several outputs may go to.
std::string output_identity(const std::string& path);

}  // namespace glowworm
