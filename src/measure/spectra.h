// Spectra of lamps and skies, by their names, colour temperatures or files.
#pragma once
#include <string>
#include <string_view>

#include "import/pbrt/spectrum.h"

namespace glowworm {

/// Relative power of a black body (Planck's law). @param kelvin > 0
SampledSpectrum planck_spectrum(double kelvin);
/// Relative power of daylight of a correlated colour temperature (CIE 15:2004, 3.1). @param kelvin 4000 to 25,000
SampledSpectrum daylight_spectrum(double kelvin);

/// The spectrum that a text names: an illuminant of the CIE (A, D50, D55, D65, D75, E, F2, F7, F11), a correlated
/// colour temperature in kelvin (black body below 5000 K and daylight from there, as CIE 13.3 takes reference
/// illuminants), or a file of pairs of wavelength (nm) and value, one a line: pbrt's .spd, or CSV with or without a
/// header. Throws Error for others.
SampledSpectrum spectrum_of_text(const std::string& text);

/// Parses such a CSV or .spd file. @param file for messages
SampledSpectrum parse_spectrum_table(std::string_view text, const std::string& file);

}  // namespace glowworm
