// IEEE 754 binary16 beside binary32, without arithmetic on subnormal floats, which a thread may have set to zero.
#pragma once
#include <bit>
#include <cstdint>

namespace glowworm {

/// Exact.
inline float half_to_float(std::uint16_t bits) {
  const std::uint32_t sign = (bits & 0x8000u) << 16, exponent = (bits >> 10) & 31u, fraction = bits & 0x3ffu;
  if (exponent == 0) {
    const float magnitude = static_cast<float>(fraction) * 0x1p-24f;
    return sign ? -magnitude : magnitude;
  }
  const std::uint32_t widened = exponent == 31 ? 255 : exponent + (127 - 15);
  return std::bit_cast<float>(sign | (widened << 23) | (fraction << 13));
}

/// To the nearest, of two as near the even one; infinity beyond 65520, NaN for NaN.
inline std::uint16_t float_to_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = (bits >> 16) & 0x8000u, magnitude = bits & 0x7fffffffu;
  if (magnitude > 0x7f800000u) return static_cast<std::uint16_t>(sign | 0x7e00u);
  const std::uint32_t exponent = magnitude >> 23;
  if (exponent >= 127 + 16) return static_cast<std::uint16_t>(sign | 0x7c00u);
  // Below 2^-25, and there is nothing to round up.
  if (exponent < 127 - 25) return static_cast<std::uint16_t>(sign);
  // Numbers below 2^-14 lose more bits, so that their last is worth 2^-24; the others are taken to a bias of 15.
  const bool subnormal = exponent < 127 - 14;
  const std::uint32_t drop = subnormal ? 13 + (127 - 14) - exponent : 13;
  const std::uint32_t whole =
      subnormal ? (magnitude & 0x7fffffu) | 0x800000u : magnitude - (std::uint32_t{127 - 15} << 23);
  const std::uint32_t last = (whole >> drop) & 1u;
  return static_cast<std::uint16_t>(sign | ((whole + (1u << (drop - 1)) - 1 + last) >> drop));
}

}  // namespace glowworm
