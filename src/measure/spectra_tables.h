// Tables of the CIE behind spectra.h and alpha_opic.h.
#pragma once
#include <array>
#include <cstddef>

namespace glowworm {

inline constexpr std::size_t kAlphaOpicCount = 5;
inline constexpr double kVisibleFirst = 380, kVisibleStep = 5;  ///< nm

/// Action spectra of CIE S 026:2018, table 2, every fifth row from 380 nm on: S-cone, M-cone and L-cone-opic, rhodopic,
/// melanopic. Beyond the last row all are below 0.0004.
inline constexpr std::size_t kActionCount = 72;
extern const std::array<std::array<double, kAlphaOpicCount>, kActionCount> kActionSpectra;

/// V(lambda), the luminous efficiency of photopic vision: CIE 018.2:1983.
inline constexpr std::size_t kVisibleCount = 81;
extern const std::array<double, kVisibleCount> kLuminousEfficiency;

/// Components S0, S1, S2 of daylight, every 10 nm from 380 nm on: CIE 15:2004, table T.2.
inline constexpr std::size_t kDaylightCount = 41;
inline constexpr double kDaylightStep = 10;  ///< nm
extern const std::array<std::array<double, 3>, kDaylightCount> kDaylightComponents;

/// Illuminants of fluorescent lamps, every 5 nm: CIE 15:2004, table T.6.
struct FluorescentLamp {
  const char* name;
  std::array<double, kVisibleCount> power;
};
extern const std::array<FluorescentLamp, 3> kFluorescentLamps;

}  // namespace glowworm
