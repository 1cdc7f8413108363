// Integrals of GGX over its visible normals, for tables.h. Internal to the BSDFs.
#pragma once
#include <array>

#include "bsdf/microfacet.h"
#include "bsdf/tables.h"

namespace glowworm::bsdf_detail {

/// A GGX surface as a node of tables: the rougher alpha, and the other one over it.
struct Facets {
  float alpha;
  float ratio = 1;
};

/// Values of Boundary for light from one direction.
using BoundaryShares = std::array<float, static_cast<std::size_t>(Boundary::count)>;
/// @param eta relative index of the denser side
BoundaryShares integrate_boundary(Facets facets, Place at, float eta);

/// Values of SchlickCurves and MirrorCurve: scale, bias, scale_out, bias_out, all.
std::array<float, 5> integrate_schlick(Facets facets, Place at);

/// Values of FresnelCurves.
std::array<float, kFresnelNodes> integrate_fresnel(Facets facets, Place at);

/// Weights of the nodes of Place::along in a mean over azimuths.
std::array<float, kAlongNodes> mean_weights_along(float ratio);

}  // namespace glowworm::bsdf_detail
