// The process that runs Assimp.
#pragma once
#include <cstdint>
#include <string>

#include "core/memory_budget.h"

namespace glowworm {

/// Program and limits of a reader process.
struct ReaderProcess {
  std::string program;  ///< path of glowworm-assimp
  std::uint64_t memory_bytes = 0;
  unsigned cpu_seconds = 0, clock_seconds = 0;
};

/// Runs the program on a file and returns its output; `held` grows by the output's size. Throws Error with the file,
/// its format and the cause if the program fails, MemoryError, and Cancelled as check_cancelled() does. The process has
/// always ended on return.
std::string run_reader(const std::string& path, const ReaderProcess& process, Reservation& held);

/// Path of the program: beside the running program or in ../libexec/glowworm; or beside the library that holds this
/// code, or in libexec/glowworm of a folder above that. Names of real files count, never the working folder.
std::string find_reader();

}  // namespace glowworm
