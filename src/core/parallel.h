// All threading goes through here; parallel.cc is the only file that includes TBB.
#pragma once
#include <cstddef>
#include <functional>

#include "core/interrupt.h"

namespace glowworm {

/// Sets how many threads parallel work uses from now on; 0: as many as the machine runs at once.
void set_thread_count(int threads);
/// How many threads parallel work uses.
int thread_count();

/// While it lives, parallel loops that this thread starts, and those within them, begin no further piece once it
/// is interrupted, and throw Cancelled (core/error.h).
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

/// Throws Cancelled where this thread's CancellationScope is interrupted: for loops of one thread that take long.
void check_cancelled();

/// Calls body(first, last) for consecutive pieces of [begin, end), each of exactly `grain` items but for the last.
/// The cut depends on begin, end and grain alone, never on threads: what a piece computes may be joined in index
/// order for the same bits from any number of threads. An exception of one piece is thrown on, after all others that
/// have begun have ended; the rest need not begin. Nested calls are allowed.
void parallel_for(std::size_t begin, std::size_t end, std::size_t grain,
                  const std::function<void(std::size_t first, std::size_t last)>& body);

/// Runs both functions, possibly at once, and returns when both are done.
void parallel_invoke(const std::function<void()>& a, const std::function<void()>& b);

}  // namespace glowworm
