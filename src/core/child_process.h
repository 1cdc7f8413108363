// Programs of this package that read files of strangers: a library that crashes on a damaged file ends its own process
// alone. core/confine.h is the other side.
#pragma once
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "core/descriptor.h"

namespace glowworm {

/// Limits of a child process for one file.
struct ChildLimits {
  std::uint64_t memory_bytes = 0;
  unsigned cpu_seconds = 0, clock_seconds = 0;
};

/// A process that runs a program. The destructor ends it and waits for it.
class ChildProcess {
 public:
  /// Starts a program. Its standard streams are closed (/dev/null); kChildDescriptor (core/confine.h) is a copy of
  /// `descriptor`. Throws Error if it cannot be started.
  /// @param variable of its environment, "NAME=VALUE", beside this process's own; may be empty
  ChildProcess(const std::string& program, std::vector<std::string> arguments, const Descriptor& descriptor,
               std::string variable = {});
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Whether the process has ended by itself.
  bool has_ended();
  /// Ends the process and returns its status as waitpid() does. A process that is already exiting keeps its exit
  /// status.
  int end();

 private:
  pid_t id_ = -1, parent_ = -1;
  int status_ = 0;
};

/// Waits until a descriptor can be read or its other end is closed; returns false if that takes until `end`. Throws
/// Cancelled as check_cancelled() does.
bool wait_to_read(const Descriptor& descriptor, std::chrono::steady_clock::time_point end);

/// What happened to a program that ended with a status of waitpid(), as the predicate of a sentence: "crashed on this
/// file (SIGSEGV): ...".
std::string describe_failure(int status, const std::string& program, const ChildLimits& limits);

/// Path of a program of this package: beside the running program or in ../libexec/glowworm; or beside the library that
/// holds this code, or in libexec/glowworm of a folder above that. Names of real files count, never the working folder.
std::string find_companion(const std::string& name);

}  // namespace glowworm
