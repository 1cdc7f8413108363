// Lines of equal value over a grid.
#pragma once
#include <span>
#include <vector>

#include "core/vec.h"

namespace glowworm {

/// A line of equal value: an open line that ends at the border of the grid, or a closed one, whose last point is the
/// first.
struct Isoline {
  float level = 0;
  std::vector<Vec2> points;  ///< in steps of the grid; (0, 0) is the first value
};

/// Lines of each level between values at grid points, by marching squares: linear along edges; saddles are joined by
/// the mean of their four values. @param values row by row; @param columns at least 1, a divisor of their number
std::vector<Isoline> isolines(std::span<const float> values, int columns, std::span<const float> levels);

/// Round levels between the least and the greatest of the values: from three to eight, a step of 1, 2 or 5 times a
/// power of ten; fewer where values differ little.
/// @param least_step differences below it are noise
std::vector<float> round_levels(std::span<const float> values, double least_step = 0);

}  // namespace glowworm
