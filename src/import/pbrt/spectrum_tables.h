// Measured tables behind spectrum.h.
#pragma once
#include <array>

namespace glowworm {

inline constexpr int kMatchingCount = 41;
inline constexpr double kMatchingFirst = 380, kMatchingStep = 10;  ///< nm

/// CIE 1931 2-degree colour matching functions x, y, z (CIE 15:2004, table T.4, every second row).
extern const std::array<std::array<double, 3>, kMatchingCount> kMatching;
/// Relative spectral power of standard illuminant D65 (CIE 15:2004, table T.1) at the same wavelengths.
extern const std::array<double, kMatchingCount> kDaylight65;

/// Wavelengths (nm) of the tables of all metals except brass.
inline constexpr int kMetalCount = 37;
extern const std::array<double, kMetalCount> kMetalWavelengths;
struct MetalTable {
  const char* name;
  std::array<double, kMetalCount> eta, k;
};
/// Silver, aluminium, gold and copper: index of refraction and extinction coefficient. Thin-film measurements of the
/// SOPRA and Palik collections, as commonly used by renderers.
extern const std::array<MetalTable, 4> kMetals;

inline constexpr int kBrassCount = 43;
inline constexpr double kBrassFirst = 380, kBrassStep = 10;  ///< nm
/// Brass (70% copper, 30% zinc): Querry, "Optical Constants", CRDC-CR-85034, 1985.
extern const std::array<double, kBrassCount> kBrassEta, kBrassK;

}  // namespace glowworm
