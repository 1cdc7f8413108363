// Processes of programs that read files by large libraries (core/child_process.h), and what they return.
#pragma once
#include <string>
#include <vector>

#include "core/child_process.h"
#include "core/memory_budget.h"

namespace glowworm {

/// A program that writes what a file holds to kChildDescriptor. Its arguments are the file, its limits on memory
/// (bytes) and processor time (s), and others.
struct ReaderProgram {
  const char* name;       ///< "glowworm-assimp"
  const char* library;    ///< that reads the files, for messages
  const char* remedy;     ///< of errors
  std::string path = {};  ///< empty: beside this program (find_companion())
};

/// Replaces zeros by limits for a file: a GiB of memory plus a thousand bytes for each of the file, but at most the
/// limit of the budget and half of the machine's memory; a minute of processor time plus two seconds per MiB of the
/// file; and ten times as many by the clock, because machines are shared.
ChildLimits limits_for(const std::string& file, const MemoryBudget& budget, ChildLimits given = {});

/// Runs a program on a file and returns its output; `held` grows by the output's size. Throws Error with the file, its
/// format and the cause if the program fails, MemoryError, and Cancelled as check_cancelled() does. The process has
/// always ended on return.
std::string run_reader(const ReaderProgram& program, const std::string& file,
                       const std::vector<std::string>& more_arguments, const ChildLimits& limits, Reservation& held);

}  // namespace glowworm
