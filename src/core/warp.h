// Sampling warps: maps from the unit square to the shapes that light is sampled over, with their densities.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/vec.h"

namespace glowworm {

/// A point of the unit disc, uniform by area, by the concentric map (Shirley and Chiu 1997): strata stay compact.
inline Vec2 square_to_disk(Vec2 u) {
  const float a = 2 * u.x - 1, b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  float radius, angle;
  if (std::abs(a) > std::abs(b)) {
    radius = a;
    angle = (kPi / 4) * (b / a);
  } else {
    radius = b;
    angle = kPi / 2 - (kPi / 4) * (a / b);
  }
  return {radius * std::cos(angle), radius * std::sin(angle)};
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

/// A direction uniform over the cone around +z in which cos(theta) >= cos_max.
inline Vec3 square_to_cone(Vec2 u, float cos_max) {
  const float z = 1 - u.x * (1 - cos_max), r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
inline float cone_pdf(float cos_max) { return 1 / (2 * kPi * (1 - cos_max)); }

/// Barycentric coordinates (of the second and third vertex) uniform over a triangle.
inline Vec2 square_to_triangle(Vec2 u) {
  const float r = std::sqrt(u.x);
  return {r * (1 - u.y), r * u.y};
}

}  // namespace glowworm
