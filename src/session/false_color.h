// Numbers as colours.
#pragma once
#include <span>
#include <vector>

#include "core/rgb.h"

namespace glowworm {

/// The ends of a scale of false colours; logarithmic.
struct ColorScale {
  float low = 0, high = 0;
};

/// A colour for t in [0, 1], linear RGB for display as it is: black, blue, cyan, green, yellow, red, white.
RGB false_color(float t);

/// The scale that shows nearly all of the values that are above 0: from their 2nd to their 98th percentile.
ColorScale fitting_scale(std::span<const float> values);

/// Each value's colour on a scale; black where the value is 0 or less.
std::vector<RGB> false_colors(std::span<const float> values, ColorScale scale);

}  // namespace glowworm
