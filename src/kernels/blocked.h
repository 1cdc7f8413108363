// The inner loops of the blocked density engine: runs of query points against blocks of photons.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/glossy.h"
#include "kernels/kernel_shape.h"

namespace glowworm {

/// Photons in a block, and children of a node of the tree over blocks.
inline constexpr int kBlockWidth = 8;
/// Query points that are looked up together. Runs are padded to a multiple of this.
inline constexpr int kTileWidth = 32;
/// Planes that may end a photon's kernel.
inline constexpr int kCuts = 2;
/// Maximum number of query points in a run.
inline constexpr int kRunPoints = 256;

/// Eight nearby photons. A lane without a photon has infinite inverse_radius_squared, so no kernel contains it.
struct alignas(32) PhotonBlock {
  float x[kBlockWidth], y[kBlockWidth], z[kBlockWidth];     ///< position, metres
  float inverse_radius_squared[kBlockWidth];                ///< m^-2
  float nx[kBlockWidth], ny[kBlockWidth], nz[kBlockWidth];  ///< unit normal
  /// flux times all factors of the kernel's profile: norm / (pi radius^2), W m^-2 sr^-1
  float r[kBlockWidth], g[kBlockWidth], b[kBlockWidth];
};

/// Planes that end the kernels of a block's photons: a point q counts where dot(normal, photon - q) < distance.
struct alignas(32) BlockCuts {
  float normal[kCuts][3][kBlockWidth];  ///< unit, from the plane to the photon; 0 without a plane
  float distance[kCuts][kBlockWidth];   ///< of the photon from the plane, metres; infinite without a plane
};

/// Bounds of eight children (blocks, or nodes of the level below). A missing child has an empty box.
struct alignas(32) BlockNode {
  float min_x[kBlockWidth], min_y[kBlockWidth], min_z[kBlockWidth];
  float max_x[kBlockWidth], max_y[kBlockWidth], max_z[kBlockWidth];
  float radius_squared[kBlockWidth];  ///< square of the largest radius of a photon, m^2, with a margin for rounding
  /// A vector near all normals (their mean), and the largest distance of a normal from it.
  float normal_x[kBlockWidth], normal_y[kBlockWidth], normal_z[kBlockWidth], normal_spread[kBlockWidth];
};

/// The photons in blocks, and the tree over them: child c of node i of level l is node 8 i + c of level l - 1, or block
/// 8 i + c if l is 0. The top level has one node.
struct BlockTree {
  const PhotonBlock* blocks = nullptr;
  std::array<const BlockNode*, 12> level{};
  int levels = 0;  ///< 0 if there are no photons
  KernelShape kernel = KernelShape::epanechnikov;
  float min_normal_cosine = 0;  ///< photons count if the dot product of the normals is above this
  /// x, y, z of the photons' directions (unit, back along their path), by place: 8 times the block plus the lane.
  const float* directions = nullptr;
  /// For each block: one more than the place of its planes in `cuts`, or 0. Null: no kernel ends at a plane.
  const std::uint32_t* cut_of_block = nullptr;
  const BlockCuts* cuts = nullptr;

  /// The planes of a block; null: none.
  const BlockCuts* cuts_of(std::size_t block) const {
    return cut_of_block && cut_of_block[block] > 0 ? cuts + cut_of_block[block] - 1 : nullptr;
  }
};

/// Nearby query points. The arrays are padded to a multiple of kTileWidth; elements beyond `count` repeat a point of
/// the run.
struct QueryRun {
  std::array<const float*, 3> position;  ///< metres
  std::array<const float*, 3> normal;    ///< unit
  std::size_t count = 0;                 ///< at most kRunPoints
  std::array<float*, 3> sum;             ///< out: sum of profile times r, g, b over the photons in support
};

/// Work done, in pairs of photon and query point (without padding) and in vector steps.
struct BlockedCounts {
  std::uint64_t tested = 0;     ///< pairs whose distance was computed
  std::uint64_t evaluated = 0;  ///< of these, pairs inside the kernel with matching normals
  std::uint64_t steps = 0;      ///< a photon against a vector of query points
  void add(const BlockedCounts& other) {
    tested += other.tested;
    evaluated += other.evaluated;
    steps += other.steps;
  }
};

/// A photon found by blocked_find(): its index (8 times the block plus the lane), and its profile at the query point.
struct BlockedPhoton {
  std::uint32_t place;
  float profile;
};

/// Working lists of a call, kept for the next call; for one thread only.
struct BlockedScratch {
  std::vector<std::uint32_t> nodes, blocks, photons;
};

/// Sums the photons at each point of the run (runs on the instruction set of set_simd()). The sum of a point is added
/// in the order of the tree: the same bits for any other points in the run.
void blocked_sum(const BlockTree& tree, const QueryRun& run, BlockedScratch& scratch, BlockedCounts& counts);

/// As above, for points of one glossy model: the sum of profile times r, g, b times pi f towards the photon.
/// @param glossy the numbers of the run's points; must be readable for padding, whose values are not used
void blocked_sum_glossy(const BlockTree& tree, const QueryRun& run, const GlossyPoints& glossy, BlockedScratch& scratch,
                        BlockedCounts& counts);

/// Replaces `found` by the photons whose support contains one point, in order of their indices.
void blocked_find(const BlockTree& tree, const float position[3], const float normal[3], BlockedScratch& scratch,
                  std::vector<BlockedPhoton>& found, BlockedCounts& counts);

}  // namespace glowworm
