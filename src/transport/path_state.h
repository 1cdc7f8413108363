// The state of a path between two surfaces.
#pragma once
#include "core/rgb.h"
#include "core/vec.h"
#include "trace/tracer.h"

namespace glowworm {

/// What a ray travels through.
struct PathMedium {
  RGB absorption{0.0f};  ///< coefficient, m^-1, at the start of the ray; the surface it meets may know more
};

/// A path on its way from one surface to the next: of a camera, a gather ray, a photon, or the path tracer. Its ray
/// holds its time.
struct PathState {
  Ray ray;
  RGB throughput{1.0f};  ///< factor on the radiance along the ray; the flux of a photon, W
  float pdf = 0;        ///< of the last direction, per steradian; 0 after cameras and deltas, where no light is sampled
  Vec3 scattered_at{};  ///< position where that direction was sampled, metres. Panes do not scatter: light samples
                        ///< pass them, too
  PathMedium medium{};
};

}  // namespace glowworm
