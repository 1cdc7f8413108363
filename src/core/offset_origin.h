// Origins of rays that leave a surface.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/vec.h"

namespace glowworm {

/// The distance along the normal at which rays must start from a triangle, so that rounding cannot make them hit it
/// again. It bounds the rounding error of all points of the triangle and of Embree's test (Moeller and Trumbore), by
/// running error analysis as in Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, section 6.8. It
/// depends only on the coordinates and the size of the triangle, so it scales with the scene: one or two units in the
/// last place of the largest coordinate, ignoring coordinates whose axis is perpendicular to the normal.
/// @param corner first vertex, metres
/// @param e1, e2 edges from there to the others, rounded; the triangle has an area
/// @return metres
inline double rounding_offset(Vec3 corner, Vec3 e1, Vec3 e2) {
  constexpr double kHalfUlp = 0x1p-24;
  double scaled[3], products[3];
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double a = static_cast<double>(e1[i]) * e2[j], b = static_cast<double>(e1[j]) * e2[i];
    scaled[k] = a - b;
    products[k] = std::abs(a) + std::abs(b);
  }
  const double doubled_area = std::sqrt(scaled[0] * scaled[0] + scaled[1] * scaled[1] + scaled[2] * scaled[2]);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double a = corner[k], b = a + e1[k], c = a + e2[k];
    const double largest = std::max({std::abs(a), std::abs(b), std::abs(c)});
    const double extent = std::max(std::abs(e1[k]), std::abs(e2[k]));
    // Rounding of the moved point; of the point itself, unless nothing is added to the corner's coordinate; of the
    // differences and products in the test; and of the edges of neighbouring triangles.
    sum += std::abs(scaled[k]) * (2 * largest + (extent > 0 ? 2 * largest : 0) + 8 * extent);
    // Rounding of the normal, which tilts it on slender triangles.
    sum += 4 * products[k] * extent;
  }
  // The last term keeps the offset above zero for a plane through the origin.
  return kHalfUlp * (sum / doubled_area + std::sqrt(doubled_area));
}

/// A bound of the rounding error of a point on a surface if its triangle is not known, metres.
inline float position_rounding(Vec3 p) { return 0x1p-22f * std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

/// The origin of rays that leave a surface at p on the side of n, the geometric normal.
/// @param offset rounding_offset() of the triangle, metres
inline Vec3 offset_origin(Vec3 p, Vec3 n, float offset) { return p + n * offset; }

}  // namespace glowworm
