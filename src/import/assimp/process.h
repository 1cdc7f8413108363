// The process that runs Assimp.
#pragma once
#include <string>

#include "core/child_process.h"
#include "core/memory_budget.h"

namespace glowworm {

/// Runs the program glowworm-assimp, which lies at `program`, on a file and returns its output; `held` grows by the
/// output's size. Throws Error with the file, its format and the cause if the program fails, MemoryError, and Cancelled
/// as check_cancelled() does. The process has always ended on return.
std::string run_assimp(const std::string& path, const std::string& program, const ChildLimits& limits,
                       Reservation& held);

}  // namespace glowworm
