// Measurements as pictures and pages for people.
#pragma once
#include <string>

#include "image/false_color.h"
#include "measure/measurement.h"

namespace glowworm {

/// Illuminance at sensors, seen along the axis that most of them face, as a PNG file in false colour with isolines and
/// a legend in lx. Between sensors values are interpolated; places far from all sensors are grey.
/// @param scale in lx; without one, fitting_scale()
std::string measurement_png(const Measurement& measured, const std::string& about, ColorScale scale);

/// A page with this picture, the numbers of the sensor that you point at, and the key figures: mean, least and most
/// illuminance, and uniformity.
std::string measurement_page(const Measurement& measured, const std::string& about, ColorScale scale);

}  // namespace glowworm
