// Frame pacing: how much work a frame does while the view moves, to reach the requested frame rate.
#pragma once
#include <cstdint>

#include "settings/cost.h"

namespace glowworm {

/// Work and time of a frame.
struct FrameWork {
  std::uint64_t pixels = 0, gather_rays = 0, photons = 0;
  double camera_seconds = 0;  ///< of all pixels: camera rays, direct light, reuse, filter
  double gather_seconds = 0;  ///< of all gather rays: tracing, density estimation, completion
  double photon_seconds = 0;  ///< of all photons: tracing, radii, index
};

/// Planned work of a frame.
struct FrameEffort {
  float scale = 1;           ///< of both sides of the picture
  std::uint32_t gather = 1;  ///< final gather rays of each camera sample
  std::uint64_t photons = 0;
};

/// Measures the cost of pixels, rays and photons on this machine and scene, and plans frames with it.
class Pace {
 public:
  static constexpr float kMinScale = 0.25f;
  static constexpr std::uint64_t kMinPhotons = 10'000;

  /// Updates the costs from a frame; work that the frame did not do keeps its cost.
  void learn(const FrameWork& work);

  /// Work that fits into `seconds`. Reduces rays first, down to a quarter, then pixels, then rays again.
  /// @param pixels, gather, photons of the whole frame; @param new_photons whether photons must be traced
  FrameEffort plan(std::uint64_t pixels, std::uint32_t gather, std::uint64_t photons, bool new_photons,
                   double seconds) const;

  /// Gather rays for a pass at rest of about `seconds`: 1 to `gather`.
  std::uint32_t resting_gather(std::uint64_t pixels, std::uint32_t gather, double seconds) const;

 private:
  Cost cost_ = kUsualCost;  // wall seconds; of one core, so that the first frames are quick
};

}  // namespace glowworm
