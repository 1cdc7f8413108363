// Numbers as colours.
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/rgb.h"
#include "image/image.h"

namespace glowworm {

/// The ends of a scale of false colours; logarithmic. The default is no scale: fitting_scale() chooses one.
struct ColorScale {
  float low = 0, high = 0;
};

/// A colour for t in [0, 1], as linear display RGB: black, blue, cyan, green, yellow, red, white.
RGB false_color(float t);

/// The scale for nearly all positive values: from their 2nd to their 98th percentile.
ColorScale fitting_scale(std::span<const float> values);

/// Colours of values on a scale; black for values of 0 or less.
std::vector<RGB> false_colors(std::span<const float> values, ColorScale scale);

/// Round numbers within a scale for its legend and its isolines, ascending: four or more unless the scale is very
/// narrow.
std::vector<float> scale_ticks(ColorScale scale);

/// The layers that illuminance_of() needs beside the image.
inline constexpr std::array kLayersOfIlluminance = {"emitted", "albedo"};

/// Illuminance of what the pixels of a picture show, lx: pi L / albedo, which is right for diffuse surfaces seen
/// straight. NaN where the albedo is below 1%. Throws Error if a layer is missing.
std::vector<float> illuminance_of(const Image& image);

/// A picture of values in false colour, with isolines at scale_ticks() and a legend on the right. Write it as PNG with
/// ToneCurve::srgb.
/// @param values row-major, first row on top, width * height; NaN: grey, nothing is there
/// @param unit of the values, above the legend
Image false_color_plot(std::span<const float> values, int width, int height, ColorScale scale, const std::string& unit);

}  // namespace glowworm
