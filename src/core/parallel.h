// All threading goes through this file; only parallel.cc includes TBB.
#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>

#include "core/interrupt.h"

namespace glowworm {

/// Sets how many threads parallel work uses from now on. 0: all hardware threads.
void set_thread_count(int threads);
/// The number of threads that parallel work uses.
int thread_count();

/// Ends the threads of parallel work and waits until they are gone; later work starts new ones. Call it at the end of
/// main(): otherwise the threads end while the process exits, at the same time as leak checkers look at them. Does
/// nothing while another thread does parallel work.
void end_threads() noexcept;

/// While this object lives, parallel loops started by this thread, and loops nested in them, stop taking new pieces
/// when interrupted, and throw Cancelled (core/error.h).
class CancellationScope {
 public:
  /// @param interrupt must outlive the scope
  explicit CancellationScope(const Interrupt& interrupt);
  ~CancellationScope();
  CancellationScope(const CancellationScope&) = delete;
  CancellationScope& operator=(const CancellationScope&) = delete;

 private:
  const Interrupt* outer_;
};

/// Throws Cancelled if this thread's CancellationScope is interrupted. Call it in long single-threaded loops.
void check_cancelled();

/// Calls body(first, last) for consecutive pieces of [begin, end), each of `grain` items except the last. The pieces
/// depend only on begin, end and grain, not on threads: join their results in index order, and you get the same bits
/// for any number of threads. If a piece throws, the remaining pieces may be skipped, and the exception is rethrown
/// when all running pieces have ended. Nested calls are allowed.
void parallel_for(std::size_t begin, std::size_t end, std::size_t grain,
                  const std::function<void(std::size_t first, std::size_t last)>& body);

/// parallel_for() of body(i) for each i below `count`.
template <class Body>
void parallel_for_each(std::size_t count, std::size_t grain, const Body& body) {
  parallel_for(0, count, grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) body(i);
  });
}

/// Items in a piece of a loop whose items take a microsecond or more: it has 256 pieces, or one for each item, so that
/// threads end together. Depends on the number of items alone.
inline constexpr std::size_t even_grain(std::size_t count) { return std::max<std::size_t>((count + 255) / 256, 1); }

/// Runs both functions, possibly in parallel, and returns when both are done.
void parallel_invoke(const std::function<void()>& a, const std::function<void()>& b);

}  // namespace glowworm
