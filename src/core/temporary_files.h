// A register of temporary files, which are removed however the program ends.
#pragma once
#include <initializer_list>
#include <string>

namespace glowworm {

/// Keeps a file's name in the register of temporary files while this object lives. A signal handler can remove all
/// registered files. Thread-safe.
class TemporaryName {
 public:
  /// Registers `path`, which need not exist yet. Throws Error if it is longer than the system allows.
  explicit TemporaryName(const std::string& path);
  /// Removes the name from the register, but not the file.
  ~TemporaryName();
  TemporaryName(const TemporaryName&) = delete;
  TemporaryName& operator=(const TemporaryName&) = delete;

 private:
  struct Entry;
  friend void remove_temporary_files() noexcept;
  Entry* entry_;
};

/// Deletes every registered file of this process. Async-signal-safe: your own signal handlers may call it.
void remove_temporary_files() noexcept;

/// Makes each of these signals delete all registered files before it ends the program. Ignored signals stay ignored.
/// Async-signal-safe.
void remove_temporary_files_at_signals(std::initializer_list<int> signals) noexcept;

/// Does the same for SIGINT, SIGTERM and SIGHUP. Also ignores SIGXFSZ and SIGPIPE, so that file size limits and closed
/// pipes give write errors (EFBIG, EPIPE) instead of ending the program.
void remove_temporary_files_at_signals() noexcept;

}  // namespace glowworm
