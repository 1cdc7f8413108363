// Lights of pbrt scenes.
#pragma once
#include <string>

#include "core/transform.h"
#include "import/pbrt/context.h"

namespace glowworm {

/// Adds the light of a LightSource directive to the scene. @param to_world the current transform
void add_light(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters,
               const TransformDouble& to_world);

/// An AreaLightSource directive, which applies to the shapes after it.
struct PbrtAreaLight {
  Emission emission;
  float power = 0;               ///< total power of each shape, W (or lm); 0: the emission's radiance applies
  float image_luminance = 1;     ///< mean luminance of the emission's image; 1 if there is none
  std::uint32_t shared = kNone;  ///< index of the emission in the scene, once it exists; unused if power is set
};

/// @param kind "diffuse" (or pbrt-v2's "area")
PbrtAreaLight make_area_light(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters);

/// Returns the index in the scene's emissions for a shape of `area` m^2 under an area light. In pbrt-v4, each triangle
/// of a mesh and each bilinear patch is a separate light, and each has the given power.
std::uint32_t add_emission(PbrtContext& context, PbrtAreaLight& light, double area);

}  // namespace glowworm
