#include "session/false_color.h"

#include <algorithm>
#include <cmath>

namespace glowworm {

RGB false_color(float t) {
  constexpr int kStops = 7;
  static const RGB stops[kStops] = {{0, 0, 0.02f},   {0, 0, 0.8f},     {0, 0.6f, 0.8f}, {0, 0.6f, 0.05f},
                                    {0.9f, 0.8f, 0}, {0.9f, 0.05f, 0}, {1, 1, 1}};
  const float at = std::clamp(t, 0.0f, 1.0f) * (kStops - 1);
  const int below = std::min(static_cast<int>(at), kStops - 2);
  return lerp(stops[below], stops[below + 1], at - static_cast<float>(below));
}

ColorScale fitting_scale(std::span<const float> values) {
  std::vector<float> positive;
  for (const float v : values)
    if (v > 0 && std::isfinite(v)) positive.push_back(v);
  if (positive.empty()) return {1, 10};
  const auto percentile = [&](double share) {
    const auto place = positive.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(positive.size() - 1));
    std::nth_element(positive.begin(), place, positive.end());
    return *place;
  };
  const float low = percentile(0.02), high = percentile(0.98);
  // A scale needs some width.
  return {low, std::max(high, 2 * low)};
}

std::vector<RGB> false_colors(std::span<const float> values, ColorScale scale) {
  std::vector<RGB> colors(values.size());
  const float low = std::log(scale.low), width = std::log(scale.high) - low;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] > 0) colors[i] = false_color((std::log(values[i]) - low) / width);
  return colors;
}

}  // namespace glowworm
