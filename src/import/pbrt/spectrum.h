// Spectra to linear Rec. 709 RGB: the one place where files' spectra become colours.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/rgb.h"

namespace glowworm {

/// A spectrum by samples, linear between them, zero outside.
struct SampledSpectrum {
  std::vector<double> wavelengths;  ///< nm, ascending
  std::vector<double> values;       ///< as many
  double at(double wavelength) const;
};

/// Linear RGB of CIE 1931 tristimulus values (IEC 61966-2-1: Rec. 709 primaries, white D65). May be negative outside
/// of the gamut.
RGB rgb_from_xyz(double x, double y, double z);

/// Colour of a black body, scaled to luminance 1 (Planck's law). @param kelvin > 0
RGB blackbody_rgb(double kelvin);

/// Colour of a light's spectrum, scaled to luminance 1, as pbrt-v4 scales light spectra; black where it is dark.
RGB illuminant_rgb(const SampledSpectrum& spectrum);
/// Colour of a light's spectrum where 1 everywhere has luminance 1, as pbrt-v3 takes them.
RGB emission_rgb(const SampledSpectrum& spectrum);

/// Colour of a reflectance under D65, so that 1 everywhere is white (1, 1, 1); clamped to [0, 1].
RGB reflectance_rgb(const SampledSpectrum& spectrum);

/// Mean of a spectrum weighted by the eye's sensitivity (CIE 1931 y); 0 where they do not overlap.
double photopic_mean(const SampledSpectrum& spectrum);

/// Complex index of refraction of a metal in three channels.
struct ConductorIndex {
  RGB eta, k;
};
/// RGB index with which the reflectance at normal incidence has the very colour that the spectra give under D65. eta is
/// averaged under each channel's sensitivity; k is then solved for.
ConductorIndex conductor_rgb(const SampledSpectrum& eta, const SampledSpectrum& k);
/// The index of a metal that has a reflectance r at normal incidence: eta = 1, k = 2 sqrt(r / (1 - r)), as pbrt-v4.
ConductorIndex conductor_from_reflectance(RGB reflectance);

/// A metal by pbrt's name: "Ag", "Al", "Au", "Cu", "CuZn"; others are not known.
struct MetalSpectra {
  SampledSpectrum eta, k;
};
std::optional<MetalSpectra> named_metal(std::string_view name);

/// Index of refraction at 587.6 nm of a glass by pbrt's name, such as "glass-BK7".
std::optional<float> named_glass(std::string_view name);

/// Colour, with luminance 1, of a standard illuminant by pbrt's name, such as "stdillum-D65" or "illum-acesD60".
std::optional<RGB> named_illuminant(std::string_view name);

/// Reads the text of an .spd file: pairs of wavelength (nm) and value, # begins a comment.
/// @param file for messages. Throws Error with the line where it is malformed or the wavelengths do not ascend.
SampledSpectrum parse_spd(std::string_view text, const std::string& file);

}  // namespace glowworm
