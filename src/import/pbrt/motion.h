// Transforms that move between two times.
#pragma once
#include <optional>

#include "core/transform_double.h"

namespace glowworm {

/// A transform at both ends of its motion. The default does not move.
struct PbrtTransforms {
  TransformDouble start, end;

  bool moves() const;
};

/// pbrt-v4's AnimatedTransform: translation, rotation and scale between two transforms, each for itself (the rotation
/// by polar decomposition, along the shorter arc). Empty if one of them has no inverse.
/// @param share of the way, in [0, 1]
std::optional<TransformDouble> between(const PbrtTransforms& ends, double share);

}  // namespace glowworm
