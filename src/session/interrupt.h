// Leaving work that is out of date.
#pragma once
#include <atomic>

#include "core/error.h"

namespace glowworm {

/// Asked between the pieces of a frame; a session's owner sets it from another thread when the view has changed.
class Interrupt {
 public:
  void request() { requested_ = true; }
  void clear() { requested_ = false; }
  bool requested() const { return requested_; }
  /// For a CancellationScope (core/parallel.h), which ends parallel loops within.
  const std::atomic<bool>& flag() const { return requested_; }
  /// Throws Cancelled where it was requested.
  void check() const {
    if (requested_) throw Cancelled();
  }

 private:
  std::atomic<bool> requested_{false};
};

}  // namespace glowworm
