// Forward SIMD photon mapping: [SF07].
#pragma once
#include <memory>
#include <span>

#include "core/large_array.h"
#include "density/engine.h"
#include "density/reorder.h"
#include "kernels/forward.h"

namespace glowworm {

/// A photon map of [SF07]: a balanced kd-tree with one photon on the split plane of every node, photon data in the
/// order of the nodes, hot apart from cold.
struct ForwardMap {
  LargeArray<ForwardNode> nodes;
  LargeArray<ForwardHot> hot;
  LargeArray<ForwardCold> cold;
  LargeArray<Vec3> direction;      ///< unit, back along the photon's path; read only by points that are not Lambertian
  LargeArray<ForwardReach> reach;  ///< only if radii differ; else empty
  float fixed_reach = 0;
  Box3 bounds;

  /// The view for the kernels; valid while the map lives.
  ForwardTree tree(const RadiusPolicy& policy) const;
};

/// Builds the map on all threads; the result does not depend on their number. @param flux of the photons, W
/// @param policy fixed or per_photon
ForwardMap build_forward_map(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy);

struct ForwardOptions {
  /// Query points in a packet: 1, 4, 8 or 16, or 0 for as many as the machine's vectors hold (at least 4).
  int lanes = 0;
  /// How query points are ordered before they are looked up: along the Hilbert curve as far as it pays. The paper's way
  /// is {ReorderMethod::octree, 16, kAutomaticDepth}.
  ReorderSettings reorder;
};

/// Packet width if ForwardOptions leave it open: the vector width of the instruction set in use, at least 4.
int forward_lanes();

/// make_forward_engine() with other options.
std::unique_ptr<DensityEngine> make_forward_engine(const ForwardOptions& options);

}  // namespace glowworm
