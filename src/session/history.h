// Earlier frames, carried over to where the camera is now.
#pragma once
#include <vector>

#include "session/view_image.h"

namespace glowworm {

/// The running mean of what earlier frames saw of each surface point ("temporal coherence", [SF07] section 8; the way
/// it is done is that of reverse reprojection caching: Nehab et al., "Accelerating Real-Time Shading with Reverse
/// Reprojection Caching", Graphics Hardware 2007). What showed another surface is rejected, by plane and normal. A
/// frame's weight falls by time, so that what is wrong (a mirror's picture, a shadow that moved) has faded to kRest of
/// itself half a second later.
class History {
 public:
  static constexpr double kLifetime = 0.5;  ///< seconds
  static constexpr double kRest = 0.02;     ///< share of a frame that is left after that

  /// Mixes earlier frames into image.light, and keeps the result for the next. Positions must be set.
  /// @param weight of this image against that of a frame in motion: its samples over theirs
  /// @param seconds since the frame before
  void blend(ViewImage& image, float weight, double seconds);
  /// Mixes as blend() does, but keeps what was there: for frames at rest, which are sums themselves.
  /// @param seconds since the history was kept
  void blend_resting(ViewImage& image, float weight, double seconds) const;

  /// Forgets all: light or mode has changed.
  void clear() { last_ = {}; }
  bool empty() const { return last_.empty(); }

 private:
  struct Found {
    RGB light;
    float weight = 0;
  };
  Found look_up(Vec3 position, Vec3 normal, bool hit) const;

  ViewImage last_;
  std::vector<float> weight_;  // frames in the mean of each pixel
};

}  // namespace glowworm
