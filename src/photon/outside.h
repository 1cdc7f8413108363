// How much places outside of the box of a scene, in a medium that fills all space, matter to a picture. Light that
// leaves a scene scatters there again and again: without this, nearly all photons would lie where no ray looks for
// them.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/box.h"
#include "core/vec.h"

namespace glowworm {

/// R / (R + d) at a distance d from the box, where R is half of its diagonal. In a medium that absorbs little, it is
/// about the probability that a photon returns: a random walk from a distance D of the middle of a sphere of radius R
/// reaches the sphere with probability R / D (Redner, "A Guide to First-Passage Processes", 2001, chapter 6). 1 where
/// the box is empty.
inline float share_that_returns(const Box3& box, Vec3 position) {
  if (box.empty()) return 1;
  Vec3 nearest;
  for (int axis = 0; axis < 3; ++axis) nearest[axis] = std::clamp(position[axis], box.min[axis], box.max[axis]);
  const float distance = length(position - nearest), radius = 0.5f * length(box.diagonal());
  return distance > 0 ? radius / (radius + distance) : 1.0f;
}

/// Density of the rays that leave the box and get as far as `position`, relative to the box: it falls as the square of
/// the distance and with the transmittance. At least 2^-16, because a camera or a point in air may be outside, too.
/// @param sigma_t m^-1
inline float share_that_looks(const Box3& box, Vec3 position, float sigma_t) {
  constexpr float kLeast = 1.0f / 65536;
  const float share = share_that_returns(box, position);
  if (!(share < 1)) return 1;
  const float distance = 0.5f * length(box.diagonal()) * (1 / share - 1);
  return std::max(share * share * std::exp(-sigma_t * distance), kLeast);
}

}  // namespace glowworm
