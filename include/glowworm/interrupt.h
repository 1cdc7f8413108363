// Requests to stop work.
#pragma once
#include <atomic>

namespace glowworm {

/// A request to stop, made by another thread or a signal handler. Work that is given it throws Cancelled soon after.
class Interrupt {
 public:
  void request() { requested_.store(true, std::memory_order_relaxed); }
  void clear() { requested_.store(false, std::memory_order_relaxed); }
  bool requested() const { return requested_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> requested_{false};
};

}  // namespace glowworm

namespace glowworm::api {

using glowworm::Interrupt;

}  // namespace glowworm::api
