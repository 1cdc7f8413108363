// Names of temporary files that must not outlive the program, whichever way it ends.
#pragma once
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

/// From now on SIGINT, SIGTERM and SIGHUP first unlink all registered files and then end the program as they would
/// have done. Signals that were ignored stay ignored. SIGXFSZ becomes ignored, so that a file size limit shows as an
/// error of the write (EFBIG) instead of ending the program.
void remove_temporary_files_at_signals();

}  // namespace glowworm
