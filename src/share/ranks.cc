#include "share/ranks.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cfenv>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <mutex>

#include "core/error.h"
#include "core/log.h"
#include "share/running_clock.h"

namespace glowworm {

namespace {

constexpr const char* kLibrary = "libglowworm_mpi.so";

/// Seconds within which all ranks join. Each rank waits longer than the one before it, so that only the first prints.
constexpr int kJoinSeconds = 600, kLater = 10;

/// The first of the variables that is a number above `least`; else `least`.
int number_of(std::initializer_list<const char*> names, int least) {
  for (const char* name : names)
    if (const char* const value = std::getenv(name))
      if (const int number = std::atoi(value); number > least) return number;
  return least;
}

/// Waits for so many seconds; returns false at once if it shall stop before.
bool waited(double seconds, const std::stop_token& stop) {
  RunningClock clock;
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any stopped;
  while (clock.seconds() < seconds)
    if (stopped.wait_for(lock, stop, std::chrono::milliseconds(100), [&] { return stop.stop_requested(); }))
      return false;
  return true;
}

/// Joining MPI waits for all ranks, without limit.
[[noreturn]] void end_unjoined() {
  const Error error(fmt::format("not all of the {} ranks have joined after {} s", launched_count(), kJoinSeconds),
                    "Look for a machine that cannot be reached, or a process that is stopped, and start again without "
                    "that machine.");
  report_error(error.what());
  std::_Exit(1);
}

}  // namespace

std::jthread watch(double seconds, std::function<void()> late) {
  return std::jthread([seconds, late = std::move(late)](const std::stop_token& stop) {
    if (waited(seconds, stop)) late();
  });
}

std::jthread repeat(double seconds, std::function<void()> call) {
  return std::jthread([seconds, call = std::move(call)](const std::stop_token& stop) {
    while (waited(seconds, stop)) call();
  });
}

int launched_count() { return number_of({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}, 1); }
int launched_here() { return number_of({"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"}, 1); }

std::unique_ptr<Ranks> join_ranks() {
  const std::jthread watcher =
      watch(kJoinSeconds + kLater * number_of({"OMPI_COMM_WORLD_RANK", "PMI_RANK"}, 0), end_unjoined);
  std::fenv_t arithmetic;
  std::fegetenv(&arithmetic);
  // Open MPI loads modules of its own, which find its symbols only if they are global.
  void* const library = dlopen(kLibrary, RTLD_NOW | RTLD_GLOBAL);
  void* const function = library ? dlsym(library, kJoinFunction) : nullptr;
  if (!function)
    throw Error(fmt::format("the library for MPI cannot be loaded ({})", dlerror()),
                fmt::format("Keep {} in the folder of the program, and install Debian's libopenmpi3, or start one "
                            "process without mpirun.",
                            kLibrary));
  std::unique_ptr<Ranks> ranks(reinterpret_cast<JoinFunction*>(function)());
  std::fesetenv(&arithmetic);
  if (ranks->count() != launched_count())
    throw Error(fmt::format("the launcher says that it started {} processes, and MPI knows of {}", launched_count(),
                            ranks->count()),
                "Start them by the mpirun of Debian's openmpi-bin.");
  return ranks;
}

}  // namespace glowworm
