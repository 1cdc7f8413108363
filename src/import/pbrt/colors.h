// Converts colours and spectra in a directive's parameters to linear RGB.
#pragma once
#include <optional>
#include <string_view>

#include "import/pbrt/context.h"
#include "import/pbrt/spectrum.h"

namespace glowworm {

/// The quantity of a colour, which determines the conversion of spectra to RGB.
enum class PbrtColorUse : std::uint8_t {
  illuminant,   ///< of a light: spectra are scaled to luminance 1, RGB is unchanged
  reflectance,  ///< clamped to [0, 1]
  unbounded,    ///< any number, such as an index of refraction
};

/// The colour of a parameter of type rgb, xyz, blackbody, spectrum or float. Empty for other types (textures) and for
/// invalid values; invalid values are also reported as errors.
std::optional<RGB> read_color(PbrtContext& context, const PbrtParameters& parameters, const PbrtParameter& parameter,
                              PbrtColorUse use);

/// The colour of a parameter by its name, or `otherwise` if it is not given.
RGB color_or(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, PbrtColorUse use,
             RGB otherwise);

/// The spectrum of a parameter of type spectrum, from inline samples or a file. Empty if it is given by a name, or if
/// it is invalid, which is reported.
std::optional<SampledSpectrum> read_spectrum(PbrtContext& context, const PbrtParameters& parameters,
                                             const PbrtParameter& parameter);

/// The complex index of refraction given by a conductor's parameters `prefix` + "eta", "k" and "reflectance"; copper if
/// none is given.
ConductorIndex read_conductor(PbrtContext& context, const PbrtParameters& parameters, std::string_view prefix);

/// An index of refraction, from a number, a named glass or the mean of a spectrum.
float read_index_of_refraction(PbrtContext& context, const PbrtParameters& parameters, std::string_view name,
                               float otherwise);

}  // namespace glowworm
