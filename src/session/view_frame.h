// A frame of a session: what a window shows and a script writes.
#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "core/statistics.h"
#include "image/false_color.h"
#include "image/image.h"
#include "session/pace.h"
#include "session/view_image.h"

namespace glowworm {

/// Cost of a frame.
struct FrameCost {
  double seconds = 0;  ///< wall time of the whole frame
  std::array<double, static_cast<std::size_t>(Phase::count_)> phase_seconds{};
  std::array<std::uint64_t, static_cast<std::size_t>(Counter::count_)> counts{};
  double reuse_seconds = 0, filter_seconds = 0;

  double phase(Phase phase) const { return phase_seconds[static_cast<std::size_t>(phase)]; }
  std::uint64_t count(Counter counter) const { return counts[static_cast<std::size_t>(counter)]; }
  /// Camera, gather and occlusion rays.
  std::uint64_t rays() const {
    return count(Counter::camera_rays) + count(Counter::gather_rays) + count(Counter::occlusion_rays);
  }
};

/// A picture of a state, at its rendered size.
struct ViewFrame {
  ViewImage image;
  bool is_light = true;       ///< radiance, which needs a tone curve; otherwise display colours
  ColorScale scale;           ///< of false colours
  std::string unit;           ///< of false colours: unit of the scale
  std::uint32_t samples = 0;  ///< camera samples of each pixel, that the picture shows
  bool moving = false;        ///< a timed frame of a moving view
  FrameEffort effort;
  std::uint64_t photons = 0;  ///< in its global map
  std::string engine;         ///< that looked up its photons
  FrameCost cost;
};

/// The frame as a picture for a file: light, and with it albedo, normal and depth.
Image frame_image(const ViewFrame& frame);

}  // namespace glowworm
