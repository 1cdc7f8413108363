// Reprojection of earlier frames to the current camera.
#pragma once
#include <span>
#include <vector>

#include "session/view_image.h"

namespace glowworm {

/// The running mean of earlier frames at each surface point ("temporal coherence", [SF07] section 8; by reverse
/// reprojection caching: Nehab et al., "Accelerating Real-Time Shading with Reverse Reprojection Caching", Graphics
/// Hardware 2007). Pixels of another surface are rejected, by plane and normal. A frame's weight decreases with time,
/// so that errors (a reflection, a shadow that moved) fade to the share kRest within half a second.
class History {
 public:
  static constexpr double kLifetime = 0.5;  ///< seconds
  static constexpr double kRest = 0.02;     ///< weight of a frame after that time

  /// Mixes earlier frames into image.light, and keeps the result for the next frame. Positions must be set.
  /// @param weight of this image relative to a frame in motion: its samples over theirs
  /// @param seconds since the previous frame
  void blend(ViewImage& image, float weight, double seconds);
  /// Mixes as blend() does, but does not change the history: for frames at rest, which are sums themselves.
  /// @param seconds since the last blend()
  void blend_resting(ViewImage& image, float weight, double seconds) const;

  /// Clears the history, because lights or mode have changed.
  void clear() { last_ = {}; }
  bool empty() const { return last_.empty(); }

 private:
  struct Found {
    RGB light;
    float weight = 0;
  };
  Found look_up(Vec3 position, Vec3 normal, bool hit) const;
  /// @param weights of the result, one a pixel, where earlier frames contribute; may be empty
  void blend_with_last(ViewImage& image, float weight, double seconds, std::span<float> weights) const;

  ViewImage last_;
  std::vector<float> weight_;  // frames in the mean of each pixel
};

}  // namespace glowworm
