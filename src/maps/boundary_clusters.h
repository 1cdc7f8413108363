// Groups of photons on one surface, for boundary correction.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.h"
#include "points/photon_batch.h"

namespace glowworm {

/// Clusters have no greater wideness; wider ones are split into single photons, whose wideness is 1.
inline constexpr float kWidestCluster = 12;
/// Share of a reach, or of a cosine, by which what is flat may deviate, in addition to rounding.
inline constexpr float kFlatness = 1e-4f;

/// Neighbouring photons with similar normals, which share their lines.
struct BoundaryCluster {
  Vec3 center;              ///< mean of the photons, metres
  Vec3 normal;              ///< mean of theirs, unit
  float reach = 0;          ///< radius of the disc around `center` that holds all discs of the photons, metres
  float low = 0, high = 0;  ///< ends of the balls of the photons along `normal`, from `center`, metres
  float wideness = 1;       ///< area of that disc over the area of a photon's disc
  float flatness = 0;  ///< largest distance of a place from the plane of `center` that counts as in the plane, metres
  float step = 0;      ///< share of a line from `high` to `low` in which rounding may hit a surface again
  bool flat = false;   ///< all photons lie in the plane of `center` and have its normal
  std::uint32_t first = 0, count = 0;  ///< a run of BoundaryClusters::photons
};

/// All photons of a batch, cut into clusters.
struct BoundaryClusters {
  std::vector<BoundaryCluster> clusters;
  std::vector<std::uint32_t> photons;  ///< indices of the batch, each once
};

/// A cluster of one kernel. @param normal unit @param radius metres
BoundaryCluster lone_cluster(Vec3 position, Vec3 normal, float radius);

/// Divides a batch into clusters; the result does not depend on threads. @param radii of the kernels, metres
BoundaryClusters make_boundary_clusters(const PhotonBatch& photons, std::span<const float> radii);

}  // namespace glowworm
