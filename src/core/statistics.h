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
  photon_noise,
  trace_paths,
  camera_pass,
  gather_rays,
  reorder,
  density,
  completion,
  direct,
  filter,
  output,
  other,
  count_
};

/// Counters; the keys of "count" in the statistics file.
enum class Counter {
  photons_emitted,
  photons_stored,
  photons_kept,
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

class PhaseTimer;

/// Counters and times of one render. Any thread may call add(). The thread that runs a phase adds its time, so times
/// are wall time, not processor time.
class Statistics {
 public:
  /// Adds the counts and times of an earlier part of the render.
  void add(const Statistics& earlier);
  void add(Counter counter, std::uint64_t n) {
    counters_[static_cast<std::size_t>(counter)].fetch_add(n, std::memory_order_relaxed);
  }
  std::uint64_t count(Counter counter) const { return counters_[static_cast<std::size_t>(counter)].load(); }

  /// Adds time that was measured otherwise. A PhaseTimer of this object that runs on this thread does not count it.
  void add_time(Phase phase, double seconds) { add_time(phase, seconds, seconds); }
  /// Wall time spent in a phase so far, in seconds.
  double seconds(Phase phase) const { return times_[static_cast<std::size_t>(phase)].load(); }

 private:
  friend class PhaseTimer;

  /// @param covered the time in which these and other phases passed, in seconds
  void add_time(Phase phase, double seconds, double covered);

  std::array<std::atomic<std::uint64_t>, static_cast<std::size_t>(Counter::count_)> counters_{};
  std::array<std::atomic<double>, static_cast<std::size_t>(Phase::count_)> times_{};
};

/// Adds the wall time between its construction and destruction to a phase, less what timers of the same statistics that
/// run meanwhile on the same thread add to theirs: phases add up to the whole.
class PhaseTimer {
 public:
  PhaseTimer(Statistics& statistics, Phase phase);
  ~PhaseTimer();
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  friend class Statistics;

  Statistics& statistics_;
  Phase phase_;
  PhaseTimer* outer_;   // of this thread, of any statistics
  double counted_ = 0;  // seconds that are in other phases
  std::chrono::steady_clock::time_point start_;
};

}  // namespace glowworm
