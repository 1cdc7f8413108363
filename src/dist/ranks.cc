#include "dist/ranks.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cfenv>
#include <cstdlib>
#include <initializer_list>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr const char* kLibrary = "libglowworm_mpi.so";

/// The first of the variables that is a number above 1; else 1.
int count_of(std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const char* const value = std::getenv(name))
      if (const int count = std::atoi(value); count > 1) return count;
  return 1;
}

}  // namespace

int launched_count() { return count_of({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}); }
int launched_here() { return count_of({"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"}); }

std::unique_ptr<Ranks> join_ranks() {
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
