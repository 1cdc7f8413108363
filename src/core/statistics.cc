#include "core/statistics.h"

namespace glowworm {

namespace {

thread_local PhaseTimer* running = nullptr;  ///< the innermost of this thread

}  // namespace

void Statistics::add(const Statistics& earlier) {
  for (std::size_t i = 0; i < counters_.size(); ++i) counters_[i] += earlier.counters_[i].load();
  for (std::size_t i = 0; i < times_.size(); ++i) times_[i].store(times_[i].load() + earlier.times_[i].load());
}

void Statistics::add_time(Phase phase, double seconds, double covered) {
  auto& slot = times_[static_cast<std::size_t>(phase)];
  slot.store(slot.load() + seconds);
  PhaseTimer* around = running;
  while (around && &around->statistics_ != this) around = around->outer_;
  if (around) around->counted_ += covered;
}

PhaseTimer::PhaseTimer(Statistics& statistics, Phase phase)
    : statistics_(statistics), phase_(phase), outer_(running), start_(std::chrono::steady_clock::now()) {
  running = this;
}

PhaseTimer::~PhaseTimer() {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  running = outer_;
  statistics_.add_time(phase_, seconds - counted_, seconds);
}

const char* name(Phase phase) {
  static constexpr const char* names[] = {
      "total",       "load",        "build_accel", "trace_photons", "build_photon_map", "photon_noise",
      "trace_paths", "camera_pass", "gather_rays", "reorder",       "density",          "completion",
      "direct",      "filter",      "output",      "other"};
  static_assert(std::size(names) == static_cast<std::size_t>(Phase::count_));
  return names[static_cast<std::size_t>(phase)];
}

const char* name(Counter counter) {
  static constexpr const char* names[] = {
      "photons_emitted",   "photons_stored", "photons_kept",   "gather_points", "gather_rays",  "query_points",
      "shader_operations", "pairs_tested",   "occlusion_rays", "camera_rays",   "packet_steps", "packet_active_lanes"};
  static_assert(std::size(names) == static_cast<std::size_t>(Counter::count_));
  return names[static_cast<std::size_t>(counter)];
}

}  // namespace glowworm
