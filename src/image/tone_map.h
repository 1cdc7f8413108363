// Converts linear radiance to display values.
#pragma once
#include <cstdint>
#include <span>

#include "core/rgb.h"

namespace glowworm {

/// The tone curve applied to radiance before it is stored in 8 bits.
enum class ToneCurve : std::uint8_t {
  srgb,   ///< clipped at 1: values can be recovered from the picture
  filmic  ///< with toe and shoulder: highlights keep their detail
};

/// The sRGB transfer function (IEC 61966-2-1, 5.2): linear [0, 1] to encoded [0, 1]. Values above 1 continue the curve;
/// negative values are mirrored.
float srgb_encode(float linear);
/// Its inverse.
float srgb_decode(float encoded);
/// srgb_decode of an 8-bit code (code / 255), from a table.
float srgb_decode(std::uint8_t code);

/// Filmic curve: linear scene value (>= 0) to linear display value in [0, 1]. The rational fit to the ACES reference
/// transform by K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2015: x(2.51x + 0.03) / (x(2.43x + 0.59) + 0.14).
float filmic_curve(float linear);

/// Linear radiance to encoded display values in [0, 1]; NaN becomes 0.
/// @param exposure in stops: multiplied by 2^exposure first
RGB tone_map(RGB linear, ToneCurve curve, float exposure);

/// The exposure in stops that maps the mean of log luminance to 18% grey (Reinhard et al., "Photographic Tone
/// Reproduction for Digital Images", 2002). Pixels that are not finite are ignored, and so are dark ones: eight stops
/// below the bright pixels (95th percentile), they would show as black beside these. 0 if there are no others.
float automatic_exposure(std::span<const RGB> pixels);

/// Rounds [0, 1] to 0…255; values outside are clipped.
std::uint8_t to_byte(float value);

}  // namespace glowworm
