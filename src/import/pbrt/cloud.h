// The procedural clouds of pbrt scenes.
#pragma once
#include "core/box.h"
#include "core/memory_budget.h"
#include "scene/medium.h"

namespace glowworm {

/// Parameters of a cloud, as pbrt-v4's medium "cloud" has them.
struct PbrtCloud {
  float density = 1, wispiness = 1, frequency = 5;
};

/// A grid of the cloud's density in [0, 1]: octaves of gradient noise (Perlin, "Improving Noise", 2002), looked up at
/// points that other noise moves, which grow denser towards y = 0 (Pharr, Jakob and Humphreys, "Physically Based
/// Rendering", 4th edition, section 11.4.4). Its noise has other gradients than pbrt's, so the cloud has another shape.
/// @param bounds in the cloud's coordinates
MediumGridValues cloud_grid(const PbrtCloud& cloud, const Box3& bounds, MemoryBudget& budget);

}  // namespace glowworm
