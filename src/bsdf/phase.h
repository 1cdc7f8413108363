// The phase function of participating media: how a point in a medium scatters light.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/frame.h"
#include "core/vec.h"

namespace glowworm {

/// Share of light that a medium scatters into a direction, per steradian (Henyey and Greenstein, "Diffuse Radiation in
/// the Galaxy", 1941).
/// @param cosine of the angle between the directions of travel before and after; @param g mean cosine, in (-1, 1)
inline float henyey_greenstein(float cosine, float g) {
  // 1 + g^2 - 2 g cosine, without cancellation where g is near 1 or -1.
  const float s = g < 0 ? -1.0f : 1.0f, rest = 1 - std::abs(g);
  const float squared = rest * rest + 2 * std::abs(g) * std::max(1 - s * cosine, 0.0f);
  return kInversePi / 4 * rest * (1 + std::abs(g)) / (squared * std::sqrt(squared));
}

/// A direction, unit, with the density henyey_greenstein(-dot(wo, direction), g).
/// @param wo unit, back along the path; @param u in [0, 1)
inline Vec3 sample_henyey_greenstein(Vec3 wo, float g, Vec2 u) {
  // 1 - cosine of the inverse distribution, in a form that holds for g = 0 and does not cancel.
  const float x = u.x, back = (1 - g) / (1 - g + 2 * g * x);
  const float away = std::min(2 * (1 - x) * (1 + g * x) * back * back, 2.0f);
  const float sine = std::sqrt(away * (2 - away)), phi = 2 * kPi * u.y;
  return Frame::from_normal(-wo).to_world({sine * std::cos(phi), sine * std::sin(phi), 1 - away});
}

}  // namespace glowworm
