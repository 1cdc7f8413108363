// BSDFs of every kind, for tests of common properties.
#pragma once
#include <string>
#include <vector>

#include "bsdf/bsdf.h"

namespace glowworm {

struct BsdfCase {
  std::string name;
  Bsdf bsdf;
};

/// One of each kind and manner of being rough.
std::vector<BsdfCase> bsdf_cases();
/// Viewers near the normal, slanted, near grazing, and below the surface.
std::vector<Vec3> viewers();

Bsdf glass(float alpha, float eta = 1.5f);
Bsdf silver(float alpha);
Bsdf coated_diffuse(RGB albedo, float alpha, float thickness = 0);
Bsdf coated_silver(float base_alpha, float coat_alpha, float thickness = 0);
Bsdf metallic_roughness(RGB color, float metallic, float alpha);

}  // namespace glowworm
