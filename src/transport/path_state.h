// The state of a path between two surfaces.
#pragma once
#include "core/rgb.h"
#include "core/vec.h"
#include "points/gather_points.h"
#include "trace/tracer.h"

namespace glowworm {

/// A path on its way from one surface to the next: of a camera, a gather ray, a photon, or the path tracer. Its ray
/// holds its time.
struct PathState {
  Ray ray;
  RGB throughput{1.0f};  ///< factor on the radiance along the ray; the flux of a photon, W
  float pdf = 0;        ///< of the last direction, per steradian; 0 after cameras and deltas, where no light is sampled
  Vec3 scattered_at{};  ///< position where that direction was sampled, metres. Panes and interfaces do not scatter:
                        ///< light samples pass them, too
  PathMedium medium{};  ///< at the start of the ray
};

}  // namespace glowworm
