// The process that runs Assimp.
#pragma once
#include <cstdint>
#include <string>

#include "core/memory_budget.h"

namespace glowworm {

/// How a process is run.
struct ReaderProcess {
  std::string program;  ///< path of glowworm-assimp
  std::uint64_t memory_bytes = 0;
  unsigned cpu_seconds = 0, clock_seconds = 0;
};

/// Lets the program read a file and returns the bytes that it hands over, which `held` grows by. Throws Error with the
/// file, its format and the cause where it does not come to its end, MemoryError, and Cancelled as check_cancelled()
/// does. No process is left behind.
std::string run_reader(const std::string& path, const ReaderProcess& process, Reservation& held);

/// Where the program is: in the folder of the running one, or in libexec/glowworm beside that.
std::string find_reader();

}  // namespace glowworm
