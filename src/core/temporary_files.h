// Names of temporary files that must not outlive the program, whichever way it ends.
#pragma once
#include <initializer_list>
#include <string>

namespace glowworm {

/// Keeps a file's name in the register of temporaries from its making to its end. The register can be emptied from
/// inside a signal handler. Thread-safe.
class TemporaryName {
 public:
  /// Registers `path`, which need not exist yet; throws Error where it is longer than the system allows.
  explicit TemporaryName(const std::string& path);
  /// Takes the name off the register; the file itself is left as it is.
  ~TemporaryName();
  TemporaryName(const TemporaryName&) = delete;
  TemporaryName& operator=(const TemporaryName&) = delete;

 private:
  struct Entry;
  friend void remove_temporary_files() noexcept;
  Entry* entry_;
};

/// Unlinks every registered file of this process. Async-signal-safe: signal handlers of one's own may call it.
void remove_temporary_files() noexcept;

/// From now on each of these signals first unlinks all registered files and then ends the program as it would have
/// done. A signal that is ignored stays so. Async-signal-safe.
void remove_temporary_files_at_signals(std::initializer_list<int> signals) noexcept;

/// The same for SIGINT, SIGTERM and SIGHUP. SIGXFSZ and SIGPIPE become ignored, so that a limit of file sizes and a
/// reader that went away show as errors of the write (EFBIG, EPIPE) instead of ending the program.
void remove_temporary_files_at_signals() noexcept;

}  // namespace glowworm
