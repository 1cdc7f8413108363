#include "image/tone_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace glowworm {

float srgb_encode(float linear) {
  const float x = std::abs(linear);
  const float encoded = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
  return std::copysign(encoded, linear);
}

float srgb_decode(float encoded) {
  const float x = std::abs(encoded);
  const float linear = x <= 0.04045f ? x / 12.92f : std::pow((x + 0.055f) / 1.055f, 2.4f);
  return std::copysign(linear, encoded);
}

float srgb_decode(std::uint8_t code) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = srgb_decode(static_cast<float>(i) / 255.0f);
    return values;
  }();
  return table[code];
}

float filmic_curve(float linear) {
  // Beyond this the curve is flat in single precision, and the squares of the fit would overflow.
  const float x = std::clamp(linear, 0.0f, 1e6f);
  return std::clamp(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f), 0.0f, 1.0f);
}

RGB tone_map(RGB linear, ToneCurve curve, float exposure) {
  const float gain = std::exp2(exposure);
  const auto map = [&](float value) {
    if (std::isnan(value)) return 0.0f;
    const float exposed = std::max(value * gain, 0.0f);
    return srgb_encode(curve == ToneCurve::filmic ? filmic_curve(exposed) : std::min(exposed, 1.0f));
  };
  return {map(linear.r), map(linear.g), map(linear.b)};
}

float automatic_exposure(std::span<const RGB> pixels) {
  constexpr float kGrey = 0.18f, kMaxStops = 60, kDark = 1.0f / 256;
  std::vector<float> lit;
  for (const RGB& pixel : pixels)
    if (const float y = luminance(pixel); std::isfinite(y) && y > 0) lit.push_back(y);
  if (lit.empty()) return 0;
  // A twentieth of the pixels is brighter: a lamp or its glints do not make the rest dark.
  const auto bright = lit.begin() + static_cast<std::ptrdiff_t>(lit.size() - 1 - lit.size() / 20);
  std::nth_element(lit.begin(), bright, lit.end());
  const float least = kDark * *bright;
  double sum = 0, count = 0;
  for (const float y : lit) {
    if (y < least) continue;
    sum += std::log2(y);
    count += 1;
  }
  return std::clamp(static_cast<float>(std::log2(kGrey) - sum / count), -kMaxStops, kMaxStops);
}

std::uint8_t to_byte(float value) {
  if (!(value > 0)) return 0;
  return static_cast<std::uint8_t>(std::min(value, 1.0f) * 255.0f + 0.5f);
}

}  // namespace glowworm
