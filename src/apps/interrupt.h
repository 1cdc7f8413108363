// Ctrl-C during a render.
#pragma once

#include "core/interrupt.h"

namespace glowworm {

/// Makes the first SIGINT, SIGTERM or SIGHUP only set a flag, so that the render can end cleanly. A second SIGINT or
/// SIGTERM removes temporary files and ends the program at once; a second SIGHUP has no effect. Ignored signals (nohup,
/// background jobs of a shell) stay ignored.
void catch_interrupts();

/// The number of the signal received since catch_interrupts(), or 0.
int caught_interrupt();

/// Requested when a signal arrives: for a CancellationScope (core/parallel.h).
const Interrupt& signal_interrupt();

}  // namespace glowworm
