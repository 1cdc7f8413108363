// Converts spectra of files to linear Rec. 709 RGB.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/rgb.h"

namespace glowworm {

/// A sampled spectrum: linear between samples, zero outside.
struct SampledSpectrum {
  std::vector<double> wavelengths;  ///< nm, ascending
  std::vector<double> values;       ///< one per wavelength
  double at(double wavelength) const;
};

/// Converts CIE 1931 tristimulus values to linear RGB (IEC 61966-2-1: Rec. 709 primaries, white D65). Colours outside
/// the gamut have negative components.
RGB rgb_from_xyz(double x, double y, double z);

/// Colour of a black body, scaled to luminance 1 (Planck's law). @param kelvin > 0
RGB blackbody_rgb(double kelvin);
/// Colour of a black body, scaled as in pbrt-v3: its spectrum is 1 at its peak, visible or not, and a constant spectrum
/// of 1 has luminance 1. @param kelvin > 0
RGB blackbody_rgb_of_peak(double kelvin);

/// Colour of a light's spectrum, scaled to luminance 1 as in pbrt-v4; black for a dark spectrum.
RGB illuminant_rgb(const SampledSpectrum& spectrum);
/// Colour of a light's spectrum, scaled as in pbrt-v3: a constant spectrum of 1 has luminance 1.
RGB emission_rgb(const SampledSpectrum& spectrum);

/// Integral of the CIE 1931 function y over wavelengths, nm: the luminance that pbrt-v4 gives a constant spectrum of 1
/// where it does not scale spectra to luminance 1.
double luminance_of_constant_spectrum();

/// Colour of a reflectance under D65, clamped to [0, 1]. A constant spectrum of 1 gives white (1, 1, 1).
RGB reflectance_rgb(const SampledSpectrum& spectrum);

/// Mean of a spectrum, weighted by the eye's sensitivity (CIE 1931 y); 0 if they do not overlap.
double photopic_mean(const SampledSpectrum& spectrum);

/// Complex index of refraction of a metal in three channels.
struct ConductorIndex {
  RGB eta, k;
};
/// RGB index whose reflectance at normal incidence has exactly the colour that the spectra give under D65. eta is the
/// average under each channel's sensitivity; k follows from the reflectance.
ConductorIndex conductor_rgb(const SampledSpectrum& eta, const SampledSpectrum& k);
/// The index of a metal with reflectance r at normal incidence, as in pbrt-v4: eta = 1, k = 2 sqrt(r / (1 - r)).
ConductorIndex conductor_from_reflectance(RGB reflectance);

/// Spectra of a metal by pbrt's name: "Ag", "Al", "Au", "Cu" or "CuZn".
struct MetalSpectra {
  SampledSpectrum eta, k;
};
std::optional<MetalSpectra> named_metal(std::string_view name);

/// Index of refraction at 587.6 nm of a glass, by pbrt's name, such as "glass-BK7".
std::optional<float> named_glass(std::string_view name);

/// Colour of a standard illuminant, scaled to luminance 1, by pbrt's name, such as "stdillum-D65" or "illum-acesD60".
std::optional<RGB> named_illuminant(std::string_view name);

/// Parses the text of an .spd file: pairs of wavelength (nm) and value; # begins a comment.
/// @param file for messages. Throws Error with the line if the text is malformed or the wavelengths do not ascend.
SampledSpectrum parse_spd(std::string_view text, const std::string& file);

}  // namespace glowworm
