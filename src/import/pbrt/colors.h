// Colours and spectra among a directive's parameters, as linear RGB.
#pragma once
#include <optional>
#include <string_view>

#include "import/pbrt/context.h"
#include "import/pbrt/spectrum.h"

namespace glowworm {

/// What a colour measures, which decides how spectra become RGB.
enum class PbrtColorUse : std::uint8_t {
  illuminant,   ///< of a light: spectra are scaled to luminance 1, RGB is taken as it is
  reflectance,  ///< clamped to [0, 1]
  unbounded,    ///< any number, such as an index of refraction
};

/// The colour of a parameter of type rgb, xyz, blackbody, spectrum or float; none where it is of another type (a
/// texture) or wrong, and then, but for textures, an error is recorded.
std::optional<RGB> read_color(PbrtContext& context, const PbrtParameters& parameters, const PbrtParameter& parameter,
                              PbrtColorUse use);

/// The same for a parameter by its name, or `otherwise` where there is none.
RGB color_or(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, PbrtColorUse use,
             RGB otherwise);

/// The spectrum of a parameter of type spectrum: inline samples or a file; none where it has a name instead, or where
/// it is wrong, which is recorded.
std::optional<SampledSpectrum> read_spectrum(PbrtContext& context, const PbrtParameters& parameters,
                                             const PbrtParameter& parameter);

/// The complex index that a conductor's parameters give, named `prefix` + "eta", "k" and "reflectance"; copper where
/// they give none.
ConductorIndex read_conductor(PbrtContext& context, const PbrtParameters& parameters, std::string_view prefix);

/// An index of refraction: a number, a named glass or a spectrum's mean.
float read_index_of_refraction(PbrtContext& context, const PbrtParameters& parameters, std::string_view name,
                               float otherwise);

}  // namespace glowworm
