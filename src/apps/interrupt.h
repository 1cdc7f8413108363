// Ctrl-C during a render.
#pragma once

#include "core/interrupt.h"

namespace glowworm {

/// From now on the first SIGINT, SIGTERM or SIGHUP is only remembered, so that the render can end in order. A SIGINT or
/// SIGTERM after it ends the program at once, without leaving temporary files; a SIGHUP after it has no effect. A
/// signal that was ignored (nohup, a shell's background) stays so.
void catch_interrupts();

/// The number of the signal that came since catch_interrupts(), or 0.
int caught_interrupt();

/// Requested as soon as a signal came: for a CancellationScope (core/parallel.h).
const Interrupt& signal_interrupt();

}  // namespace glowworm
