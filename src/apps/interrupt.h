// Ctrl-C during a render.
#pragma once

namespace glowworm {

/// From now on the first SIGINT, SIGTERM or SIGHUP is only remembered, so that the render can end in order. A SIGINT or
/// SIGTERM after it ends the program at once, without leaving temporary files; a SIGHUP after it has no effect. A
/// signal that was ignored (nohup, a shell's background) stays so.
void catch_interrupts();

/// The number of the signal that came since catch_interrupts(), or 0.
int caught_interrupt();

}  // namespace glowworm
