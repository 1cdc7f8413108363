// How much of a frame is done while the view moves, so that frames come at the rate asked for.
#pragma once
#include <cstdint>

namespace glowworm {

/// What a frame did and how long it took.
struct FrameWork {
  std::uint64_t pixels = 0, gather_rays = 0, photons = 0;
  double camera_seconds = 0;  ///< all that goes by the pixel: camera rays, direct light, reuse, filter
  double gather_seconds = 0;  ///< all that goes by the gather ray: tracing, density estimation, completion
  double photon_seconds = 0;  ///< all that goes by the photon: tracing, radii, index
};

/// What a frame is to do.
struct FrameEffort {
  float scale = 1;           ///< of both sides of the picture
  std::uint32_t gather = 1;  ///< final gather rays of each camera sample
  std::uint64_t photons = 0;
};

/// Learns what pixels, rays and photons cost on this machine and scene, and plans frames with that.
class Pace {
 public:
  static constexpr float kSmallestScale = 0.25f;
  static constexpr std::uint64_t kFewestPhotons = 10'000;

  /// Learns from a frame; parts that did nothing leave what is known of them.
  void learn(const FrameWork& work);

  /// What fits into `seconds`. Rays are given up first, down to a quarter, then pixels, then rays again.
  /// @param pixels, gather, photons of the whole frame; @param new_photons whether photons must be traced
  FrameEffort plan(std::uint64_t pixels, std::uint32_t gather, std::uint64_t photons, bool new_photons,
                   double seconds) const;

  /// Gather rays for a pass at rest that shall take about `seconds`: 1 to `gather`.
  std::uint32_t resting_gather(std::uint64_t pixels, std::uint32_t gather, double seconds) const;

 private:
  // Seconds each; at first those of a slow machine, so that the first frames come soon.
  double pixel_ = 1e-6, ray_ = 1e-6, photon_ = 4e-6;
};

}  // namespace glowworm
