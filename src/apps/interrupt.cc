#include "apps/interrupt.h"

#include <signal.h>

#include <atomic>

#include "core/temporary_files.h"

namespace glowworm {

namespace {

volatile sig_atomic_t caught = 0;
std::atomic<bool> flag{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // as signal handlers need it

extern "C" void remember_and_arm(int number) {
  caught = number;
  flag = true;
  // The next one shall end the program; both calls within are safe in signal handlers.
  remove_temporary_files_at_signals();
}

}  // namespace

void catch_interrupts() {
  for (const int number : {SIGINT, SIGTERM}) {
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

const std::atomic<bool>& interrupt_flag() { return flag; }

}  // namespace glowworm
