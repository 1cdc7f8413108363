// Ctrl-C during a render.
#pragma once
#include <atomic>

namespace glowworm {

/// From now on the first SIGINT or SIGTERM is only remembered, so that the render can end in order; the second ends the
/// program at once, without leaving temporary files. A signal that was ignored (nohup, a shell's background) stays so.
void catch_interrupts();

/// The number of the signal that came since catch_interrupts(), or 0.
int caught_interrupt();

/// Set as soon as a signal came: for a CancellationScope (core/parallel.h).
const std::atomic<bool>& interrupt_flag();

}  // namespace glowworm
