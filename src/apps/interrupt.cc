#include "apps/interrupt.h"

#include <signal.h>

#include <atomic>

#include "core/temporary_files.h"

namespace glowworm {

namespace {

volatile sig_atomic_t caught = 0;
Interrupt interrupt;
static_assert(std::atomic<bool>::is_always_lock_free);  // signal handlers need that

extern "C" void remember_and_arm(int number) {
  if (caught == 0) caught = number;
  interrupt.request();
  // The next one ends the program. A hangup does not: a terminal that closes often sends two, and the end of a login
  // session sends one beside SIGTERM.
  remove_temporary_files_at_signals({SIGINT, SIGTERM});
}

}  // namespace

void catch_interrupts() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction old {};
    sigaction(number, nullptr, &old);
    if (old.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = remember_and_arm;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(number, &action, nullptr);
  }
}

int caught_interrupt() { return caught; }

const Interrupt& signal_interrupt() { return interrupt; }

}  // namespace glowworm
