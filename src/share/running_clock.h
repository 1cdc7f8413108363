// Limits of time between processes.
#pragma once
#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>

namespace glowworm {

/// Counts the time for which this process runs. A process that was stopped for minutes must not think that the others
/// were silent.
class RunningClock {
 public:
  /// Seconds since the clock was made. A second is the most that passes from call to call.
  double seconds() {
    const std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now();
    seconds_ += std::min(std::chrono::duration<double>(now - last_).count(), 1.0);
    last_ = now;
    return seconds_;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  double seconds_ = 0;
};

/// A thread that calls `late` once unless it is destroyed within so many seconds.
std::jthread watch(double seconds, std::function<void()> late);
/// A thread that calls `call` each time so many seconds have passed, until it is destroyed.
std::jthread repeat(double seconds, std::function<void()> call);

}  // namespace glowworm
