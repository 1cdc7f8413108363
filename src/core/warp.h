// Sampling warps: maps from the unit square to the domains over which light is sampled, with their densities.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/vec.h"

namespace glowworm {

/// Sine and cosine of x in [-pi/4, pi/4], accurate to a unit or two in the last place (polynomials of Moshier's Cephes
/// library). Much faster than the standard functions, which accept any x.
inline Vec2 sine_and_cosine_of_octant(float x) {
  const float square = x * x;
  const float s = (-1.9515295891e-4f * square + 8.3321608736e-3f) * square - 1.6666654611e-1f;
  const float c = (2.443315711809948e-5f * square - 1.388731625493765e-3f) * square + 4.166664568298827e-2f;
  return {s * square * x + x, c * square * square + (1 - 0.5f * square)};
}

/// A point of the unit disc, uniform by area, by the concentric map (Shirley and Chiu 1997), which keeps strata
/// compact.
inline Vec2 square_to_disk(Vec2 u) {
  const float a = 2 * u.x - 1, b = 2 * u.y - 1;
  // In the steep sectors the angle is measured from the other axis, so sine and cosine are swapped.
  const bool steep = std::abs(b) >= std::abs(a);
  const float radius = steep ? b : a, other = steep ? a : b;
  const Vec2 at = sine_and_cosine_of_octant((kPi / 4) * (other / (radius == 0 ? 1.0f : radius)));
  return steep ? Vec2{radius * at.x, radius * at.y} : Vec2{radius * at.y, radius * at.x};
}

/// The point of the square that square_to_disk() maps to a point of the disc.
inline Vec2 disk_to_square(Vec2 p) {
  const bool steep = std::abs(p.y) >= std::abs(p.x);
  const float along = steep ? p.y : p.x, across = steep ? p.x : p.y;
  const float radius = std::copysign(std::sqrt(p.x * p.x + p.y * p.y), along);
  const float other = radius * (4 / kPi) * std::atan(across / (along == 0 ? 1.0f : along));
  return {((steep ? other : radius) + 1) / 2, ((steep ? radius : other) + 1) / 2};
}

/// A direction around +z with density cos(theta) / pi per steradian (Malley's method).
inline Vec3 square_to_cosine_hemisphere(Vec2 u) {
  const Vec2 d = square_to_disk(u);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}
inline float cosine_hemisphere_pdf(float cos_theta) { return std::max(0.0f, cos_theta) * kInversePi; }

/// A direction uniform over the sphere, density 1 / (4 pi) per steradian.
inline Vec3 square_to_sphere(Vec2 u) {
  const float z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
inline constexpr float kUniformSpherePdf = kInversePi / 4;

/// Barycentric coordinates of the second and third vertex, uniform over a triangle.
inline Vec2 square_to_triangle(Vec2 u) {
  const float r = std::sqrt(u.x);
  return {r * (1 - u.y), r * u.y};
}

}  // namespace glowworm
