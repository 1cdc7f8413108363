// Measured coefficients of media and of subsurface scattering, by the names that pbrt files give them.
#pragma once
#include <string>
#include <string_view>

#include "core/rgb.h"

namespace glowworm {

/// Coefficients of a substance, mm^-1. Scattering is reduced: by isotropic scattering, it looks as the measured one.
struct MediumPreset {
  std::string_view name;
  RGB sigma_s, sigma_a;
};

/// The preset of that name, or null.
const MediumPreset* find_medium_preset(std::string_view name);
/// All names, with commas between them.
std::string medium_preset_names();

}  // namespace glowworm
