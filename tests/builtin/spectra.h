// The measured spectra of the Cornell box and their colours.
#pragma once
#include <array>

#include "core/rgb.h"

namespace glowworm {

inline constexpr int kCornellFirstWavelength = 400;  ///< nm
inline constexpr int kCornellWavelengthStep = 4;     ///< nm
/// 76 samples from 400 to 700 nm.
using CornellSpectrum = std::array<double, 76>;

/// Measured reflectances. Source: Cornell University Program of Computer Graphics, "Cornell Box Data",
/// https://www.graphics.cornell.edu/online/box/data.html.
extern const CornellSpectrum kCornellWhite, kCornellGreen, kCornellRed;
/// The light's radiance in the source's units, taken here as W sr^-1 m^-2 as described at cornell_color(). Linear
/// between the measured points 400 nm: 0, 500 nm: 8, 600 nm: 15.6, 700 nm: 18.4.
CornellSpectrum cornell_light();

/// The linear Rec. 709 colour of a spectrum, scaled so that the equal-energy spectrum of 1 has luminance 1: CIE 1931
/// matching functions as fitted by Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ Color
/// Matching Functions", JCGT 2(2), 2013, section 2.2; XYZ to RGB by IEC 61966-2-1.
RGB cornell_color(const CornellSpectrum& spectrum);

/// The RGB reflectance that gives light of the box's own lamp, reflected once, exactly the colour computed by spectra:
/// cornell_color(light * reflectance) / cornell_color(light).
RGB cornell_reflectance(const CornellSpectrum& reflectance);

}  // namespace glowworm
