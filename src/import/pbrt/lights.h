// Lights of pbrt scenes.
#pragma once
#include <string>

#include "core/transform.h"
#include "import/pbrt/context.h"

namespace glowworm {

/// Adds the light of a LightSource directive to the scene. @param to_world the transform in force there
void add_light(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters,
               const Transform& to_world);

/// What an AreaLightSource directive says of the shapes that follow it.
struct PbrtAreaLight {
  Emission emission;
  float power = 0;               ///< W (or lm) that each shape sends out in all; 0: by the emission's radiance
  float image_luminance = 1;     ///< mean luminance of the emission's image, 1 where there is none
  std::uint32_t shared = kNone;  ///< index of the emission in the scene once it is there; unused where power is set
};

/// @param kind "diffuse" (or pbrt-v2's "area")
PbrtAreaLight make_area_light(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters);

/// Index in the scene's emissions of what a shape of `area` m^2 emits under an area light. pbrt-v4 takes each triangle
/// of a mesh and each bilinear patch as a light of its own, which a given power is the power of.
std::uint32_t add_emission(PbrtContext& context, PbrtAreaLight& light, double area);

}  // namespace glowworm
