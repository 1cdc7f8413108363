// Counters and times of a render. Each entry has a type, a unit and one place that adds to it.
#pragma once
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>

namespace glowworm {

/// Wall-clock phases of a render, in seconds; the keys of "time_s" in the statistics file.
enum class Phase {
  total,
  load,
  build_accel,
  trace_photons,
  build_photon_map,
  camera_pass,
  gather_rays,
  reorder,
  density,
  completion,
  direct,
  output,
  count_
};

/// Counters; the keys of "count" in the statistics file.
enum class Counter {
  photons_emitted,
  photons_stored,
  gather_points,
  gather_rays,
  query_points,
  shader_operations,
  pairs_tested,
  occlusion_rays,
  camera_rays,
  packet_steps,
  packet_active_lanes,
  count_
};

const char* name(Phase phase);
const char* name(Counter counter);

/// Counters and times of one render. Any thread may call add(). The thread that runs a phase adds its time, so times
/// are wall time, not processor time.
class Statistics {
 public:
  void add(Counter counter, std::uint64_t n) {
    counters_[static_cast<std::size_t>(counter)].fetch_add(n, std::memory_order_relaxed);
  }
  std::uint64_t count(Counter counter) const { return counters_[static_cast<std::size_t>(counter)].load(); }

  void add_time(Phase phase, double seconds) {
    auto& slot = times_[static_cast<std::size_t>(phase)];
    slot.store(slot.load() + seconds);
  }
  /// Wall time spent in a phase so far, in seconds.
  double seconds(Phase phase) const { return times_[static_cast<std::size_t>(phase)].load(); }

 private:
  std::array<std::atomic<std::uint64_t>, static_cast<std::size_t>(Counter::count_)> counters_{};
  std::array<std::atomic<double>, static_cast<std::size_t>(Phase::count_)> times_{};
};

/// Adds the wall time between its construction and destruction to a phase.
class PhaseTimer {
 public:
  PhaseTimer(Statistics& statistics, Phase phase)
      : statistics_(statistics), phase_(phase), start_(std::chrono::steady_clock::now()) {}
  ~PhaseTimer() {
    statistics_.add_time(phase_, std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count());
  }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  Statistics& statistics_;
  Phase phase_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace glowworm
