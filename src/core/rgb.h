// Colour: linear RGB with Rec. 709 primaries. The name of a value says whether it is flux, radiance or reflectance.
#pragma once
#include <algorithm>
#include <cmath>

namespace glowworm {

/// Linear RGB, Rec. 709 primaries: flux in W, radiance in W sr^-1 m^-2, irradiance in W m^-2, or a reflectance.
struct RGB {
  float r = 0, g = 0, b = 0;
  RGB() = default;
  constexpr RGB(float red, float green, float blue) : r(red), g(green), b(blue) {}
  constexpr explicit RGB(float grey) : r(grey), g(grey), b(grey) {}
  float operator[](int channel) const { return channel == 0 ? r : channel == 1 ? g : b; }
  float& operator[](int channel) { return channel == 0 ? r : channel == 1 ? g : b; }
};

inline RGB operator+(RGB a, RGB b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
inline RGB operator-(RGB a, RGB b) { return {a.r - b.r, a.g - b.g, a.b - b.b}; }
inline RGB operator*(RGB a, RGB b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
inline RGB operator*(RGB a, float s) { return {a.r * s, a.g * s, a.b * s}; }
inline RGB operator*(float s, RGB a) { return a * s; }
inline RGB operator/(RGB a, float s) { return {a.r / s, a.g / s, a.b / s}; }
inline RGB operator/(RGB a, RGB b) { return {a.r / b.r, a.g / b.g, a.b / b.b}; }
inline RGB& operator+=(RGB& a, RGB b) { return a = a + b; }
inline RGB& operator*=(RGB& a, RGB b) { return a = a * b; }
inline RGB& operator*=(RGB& a, float s) { return a = a * s; }
inline bool operator==(RGB a, RGB b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

/// Luminous efficacy of white light as Radiance takes it, lm/W: luminance() of watts times this is photometric. All
/// photometric units, read and written, become radiometric by it.
inline constexpr float kLuminousEfficacy = 179;

/// Luminance by the Rec. 709 weights (ITU-R BT.709-6, item 3.2), in the unit of a.
inline float luminance(RGB a) { return 0.2126f * a.r + 0.7152f * a.g + 0.0722f * a.b; }
inline float max_component(RGB a) { return std::max(a.r, std::max(a.g, a.b)); }
inline float mean(RGB a) { return (a.r + a.g + a.b) / 3; }
inline bool is_black(RGB a) { return a.r == 0 && a.g == 0 && a.b == 0; }
inline bool is_finite(RGB a) { return std::isfinite(a.r) && std::isfinite(a.g) && std::isfinite(a.b); }
inline RGB clamp(RGB a, float low, float high) {
  return {std::clamp(a.r, low, high), std::clamp(a.g, low, high), std::clamp(a.b, low, high)};
}
inline RGB sqrt(RGB a) { return {std::sqrt(a.r), std::sqrt(a.g), std::sqrt(a.b)}; }
inline RGB lerp(RGB a, RGB b, float t) { return a * (1 - t) + b * t; }

}  // namespace glowworm
