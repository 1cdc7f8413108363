// The inner loops of the blocked density engine: runs of query points against blocks of photons.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/glossy.h"
#include "kernels/kernel_shape.h"

namespace glowworm {

/// Photons of a block, and children of a node of the tree over blocks.
inline constexpr int kBlockWidth = 8;
/// Query points that are looked up together. Runs are padded to a multiple of it.
inline constexpr int kTileWidth = 32;
/// Most query points of a run.
inline constexpr int kRunPoints = 256;

/// Eight photons that lie together. A lane without photon has inverse_radius_squared infinite, and is in no kernel.
struct alignas(32) PhotonBlock {
  float x[kBlockWidth], y[kBlockWidth], z[kBlockWidth];     ///< position, metres
  float inverse_radius_squared[kBlockWidth];                ///< m^-2
  float nx[kBlockWidth], ny[kBlockWidth], nz[kBlockWidth];  ///< unit normal
  /// flux times everything that multiplies the kernel's profile: norm / (pi radius^2), W m^-2 sr^-1
  float r[kBlockWidth], g[kBlockWidth], b[kBlockWidth];
};

/// What eight children (blocks, or nodes of the level below) hold. A child that is not there has an empty box.
struct alignas(32) BlockNode {
  float min_x[kBlockWidth], min_y[kBlockWidth], min_z[kBlockWidth];
  float max_x[kBlockWidth], max_y[kBlockWidth], max_z[kBlockWidth];
  float radius_squared[kBlockWidth];  ///< square of the largest radius of a photon, m^2, with room for rounding
  /// A vector near all normals (their mean), and how far at most a normal is away from it.
  float normal_x[kBlockWidth], normal_y[kBlockWidth], normal_z[kBlockWidth], normal_spread[kBlockWidth];
};

/// The photons in blocks, and the tree over them: child c of node i of level l is node 8 i + c of level l - 1, or block
/// 8 i + c where l is 0. The uppermost level has one node.
struct BlockTree {
  const PhotonBlock* blocks = nullptr;
  std::array<const BlockNode*, 12> level{};
  int levels = 0;  ///< 0 where there are no photons
  KernelShape kernel = KernelShape::epanechnikov;
  float min_normal_cosine = 0;  ///< photons count where the dot product of the normals is above this
  /// x, y, z of the photons' directions (unit, back along their way), by place: 8 times the block plus the lane.
  const float* directions = nullptr;
};

/// Query points that lie together. The arrays have room for a multiple of kTileWidth; behind `count` they repeat a
/// point of the run.
struct QueryRun {
  std::array<const float*, 3> position;  ///< metres
  std::array<const float*, 3> normal;    ///< unit
  std::size_t count = 0;                 ///< at most kRunPoints
  std::array<float*, 3> sum;             ///< out: sum of profile times r, g, b over the photons in support
};

/// What was done, in pairs of a photon and a query point (padding not counted) and in steps of a vector.
struct BlockedCounts {
  std::uint64_t tested = 0;     ///< pairs whose distance was computed
  std::uint64_t evaluated = 0;  ///< of them inside the kernel, on the side of the normal
  std::uint64_t steps = 0;      ///< a photon against a vector of query points
  void add(const BlockedCounts& other) {
    tested += other.tested;
    evaluated += other.evaluated;
    steps += other.steps;
  }
};

/// A photon found by blocked_find(): its place (8 times the block plus the lane), and its profile at the query point.
struct BlockedPhoton {
  std::uint32_t place;
  float profile;
};

/// Lists that a call works with and that are kept for the next; belongs to one thread.
struct BlockedScratch {
  std::vector<std::uint32_t> nodes, blocks, photons;
};

/// Sums the photons at each point of the run (runs on the instruction set of set_simd()). The sum of a point is added
/// up in the order of the tree: the same bits whatever other points are in the run.
void blocked_sum(const BlockTree& tree, const QueryRun& run, BlockedScratch& scratch, BlockedCounts& counts);

/// The same for points of one glossy model: the sum of profile times r, g, b times pi f towards the photon.
/// @param glossy the numbers of the run's points; readable for padding, whose numbers mean nothing
void blocked_sum_glossy(const BlockTree& tree, const QueryRun& run, const GlossyPoints& glossy, BlockedScratch& scratch,
                        BlockedCounts& counts);

/// Replaces `found` by the photons in support at one point, in order of their places.
void blocked_find(const BlockTree& tree, const float position[3], const float normal[3], BlockedScratch& scratch,
                  std::vector<BlockedPhoton>& found, BlockedCounts& counts);

/// blocked_sum() in plain C++, every photon of the blocks against every point in single precision: what the vector
/// code is tested against. Does not count steps.
void blocked_sum_reference(const BlockTree& tree, std::size_t blocks, const QueryRun& run, BlockedCounts& counts);

}  // namespace glowworm
