// Units of light in glTF files.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "core/rgb.h"

namespace glowworm {

/// The numbers by which a glTF file gives one unit of light.
///
/// glTF 2.0 gives lights in candela and lux, which become watts by kLuminousEfficacy. It gives emission in candela per
/// square metre, too, but files do not: viewers show 1 as white, and Blender writes W sr^-1 m^-2
/// (github.com/KhronosGroup/glTF-Blender-IO/issues/1766). So emission counts as W sr^-1 m^-2.
///
/// A bake writes for viewers, which take both in the same unit: radiometric units times 2^exposure. Its extras hold the
/// exposure, so reading a baked file at the same scale gives the light of the scene that was baked.
struct GltfLightUnits {
  float radiance = 1;                    ///< emission of 1 W sr^-1 m^-2
  float irradiance = kLuminousEfficacy;  ///< number of a directional light of 1 W m^-2
  float intensity = kLuminousEfficacy;   ///< number of another light of 1 W sr^-1
};

/// The units of a file. @param file all of its JSON
GltfLightUnits light_units(const nlohmann::json& file);

/// What bakes write into asset.extras.glowworm, for light_units().
inline constexpr const char *kExposureStops = "exposure_stops", *kMetresPerUnit = "metres_per_unit";

}  // namespace glowworm
