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

/// A colour for t in [0, 1], as linear display RGB: black, blue, cyan, green, yellow, red, white.
RGB false_color(float t);

/// The scale for nearly all positive values: from their 2nd to their 98th percentile.
ColorScale fitting_scale(std::span<const float> values);

/// Colours of values on a scale; black for values of 0 or less.
std::vector<RGB> false_colors(std::span<const float> values, ColorScale scale);

}  // namespace glowworm
