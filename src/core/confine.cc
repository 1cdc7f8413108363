#include "core/confine.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>

namespace glowworm {

namespace {

constexpr rlim_t kStackBytes = rlim_t{16} << 20, kOpenFiles = 64;

/// Limits a resource. A later call may raise the limit again.
void set_limit(__rlimit_resource resource, rlim_t most) {
  rlimit limits{};
  getrlimit(resource, &limits);
  limits.rlim_cur = std::min(limits.rlim_max, most);
  if (setrlimit(resource, &limits) != 0) end_child(ChildExit::misused);
}

}  // namespace

void end_child(ChildExit status) { _exit(static_cast<int>(status)); }

void confine() {
  signal(SIGINT, SIG_IGN);
  for (const int number : {SIGXCPU, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) signal(number, SIG_DFL);
  close_range(kChildDescriptor + 1, ~0u, 0);
  set_limit(RLIMIT_STACK, kStackBytes);
  set_limit(RLIMIT_NOFILE, kOpenFiles);
  set_limit(RLIMIT_FSIZE, 0);  // it writes no files
  set_limit(RLIMIT_CORE, 0);
  std::set_new_handler([] { end_child(ChildExit::out_of_memory); });
}

void limit_child(std::uint64_t memory_bytes, unsigned cpu_seconds) {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  set_limit(RLIMIT_AS, memory_bytes);
  set_limit(RLIMIT_CPU, static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + cpu_seconds);
}

void send_to_parent(const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t sent = write(kChildDescriptor, at, size);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) end_child(ChildExit::misused);
    at += sent;
    size -= static_cast<std::size_t>(sent);
  }
}

void read_for_parent(int argc, char** argv, int count, const std::function<void()>& read) {
  // The parent may end at any time.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (argc != count || getppid() == 1) end_child(ChildExit::misused);
  confine();
  limit_child(std::strtoull(argv[2], nullptr, 10), static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10)));
  try {
    read();
  } catch (const std::bad_alloc&) {
    end_child(ChildExit::out_of_memory);
  } catch (const std::exception& error) {
    send_to_parent(error.what(), std::strlen(error.what()));
    end_child(ChildExit::refused);
  }
  end_child(ChildExit{0});
}

}  // namespace glowworm
