#include "core/statistics.h"

namespace glowworm {

const char* name(Phase phase) {
  static constexpr const char* names[] = {
      "total",       "load",    "build_accel", "trace_photons", "build_photon_map", "camera_pass",
      "gather_rays", "reorder", "density",     "completion",    "direct",           "output"};
  static_assert(std::size(names) == static_cast<std::size_t>(Phase::count_));
  return names[static_cast<std::size_t>(phase)];
}

const char* name(Counter counter) {
  static constexpr const char* names[] = {
      "photons_emitted", "photons_stored", "gather_points", "gather_rays",  "query_points",       "shader_operations",
      "pairs_tested",    "occlusion_rays", "camera_rays",   "packet_steps", "packet_active_lanes"};
  static_assert(std::size(names) == static_cast<std::size_t>(Counter::count_));
  return names[static_cast<std::size_t>(counter)];
}

}  // namespace glowworm
