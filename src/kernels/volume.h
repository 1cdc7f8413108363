// The inner loops of maps of volume photons: tiles of segments against blocks of photons, or of pieces of beams.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace glowworm {

/// Photons in a block, and children of a node of the tree over blocks.
inline constexpr int kVolumeBlock = 8;
/// Segments in a tile.
inline constexpr int kSegmentTile = 16;
/// Rounding of a crossing with a piece of a beam, in lengths of the piece: the test finds no segment that is further
/// away than the radius and this.
inline constexpr float kBeamRounding = 1e-3f;

/// Two walls of a photon face each other in a disc if the cosine of their normals is below kFacing there. In a gap
/// narrower than kNarrowGap radii, the few mirror images that are used would lose flux, so the disc is spread evenly
/// across the gap.
inline constexpr float kFacing = -0.8f, kNarrowGap = 0.65f;

/// Eight nearby photons. The last photon of a tree fills the lanes behind it, without flux.
struct alignas(32) VolumePhotonBlock {
  float x[kVolumeBlock], y[kVolumeBlock], z[kVolumeBlock];     ///< position, metres
  float inverse_radius_squared[kVolumeBlock];                  ///< m^-2
  float dx[kVolumeBlock], dy[kVolumeBlock], dz[kVolumeBlock];  ///< direction of travel, unit
  float r[kVolumeBlock], g[kVolumeBlock], b[kVolumeBlock];     ///< flux times 2 / (pi radius^2), W m^-2
  float wall[2][3][kVolumeBlock];                              ///< PhotonKernels::walls, m^-1
};

/// Eight nearby pieces of beams. The last piece of a tree fills the lanes behind it, without flux.
struct alignas(32) BeamBlock {
  float x[kVolumeBlock], y[kVolumeBlock], z[kVolumeBlock];     ///< where the piece begins, metres
  float dx[kVolumeBlock], dy[kVolumeBlock], dz[kVolumeBlock];  ///< direction of travel, unit
  float radius_squared[kVolumeBlock];                          ///< m^2
  float length[kVolumeBlock];                                  ///< metres
  float r[kVolumeBlock], g[kVolumeBlock], b[kVolumeBlock];     ///< flux times 2 / (pi radius^2), W m^-2
};

/// Radius of a child that is not there: no segment is within it.
inline constexpr float kNoRadius = -1e30f;

/// Bounds of eight children (blocks, or nodes of the level below): a box around photons, and their largest radius. A
/// missing child has the radius kNoRadius.
struct alignas(32) VolumeNode {
  float center_x[kVolumeBlock], center_y[kVolumeBlock], center_z[kVolumeBlock];  ///< metres
  float half_x[kVolumeBlock], half_y[kVolumeBlock], half_z[kVolumeBlock];        ///< half of each side, metres
  float radius[kVolumeBlock];                                                    ///< metres
};

/// Photons or pieces of beams of one medium in blocks, and the tree over them: child c of node i of level l is node
/// 8 i + c of level l - 1, or block 8 i + c if l is 0. The top level has one node.
struct VolumeTree {
  const VolumePhotonBlock* photons = nullptr;
  const BeamBlock* beams = nullptr;  ///< null: the blocks hold photons
  std::array<const VolumeNode*, 12> level{};
  int levels = 0;  ///< 0 if there is nothing
};

/// Bounds of a tile: segments are where point + s axis + w, with w normal to the axis, has low <= s <= high and |w| <=
/// width + slope s.
struct SegmentBounds {
  float point[3];      ///< metres
  float axis[3];       ///< unit
  float low, high;     ///< metres
  float width, slope;  ///< metres; slope is not negative
  float rounding = 0;  ///< added to all distances, metres
};

/// Segments in one medium. Lanes from `count` on are padding: their length is -1, so nothing is in them.
struct alignas(64) SegmentTile {
  float origin[3][kSegmentTile];     ///< metres
  float direction[3][kSegmentTile];  ///< unit
  float length[kSegmentTile];        ///< metres; may be infinite
  float sigma_t[3][kSegmentTile];    ///< of each channel, m^-1
  float g[kSegmentTile];             ///< of the phase function
  float sum[3][kSegmentTile];        ///< out: W m^-2, or W m^-1 for beams, times 4 pi / (1 - g^2) p
  std::size_t count = 0;
  bool grey = false;       ///< whether sigma_t is the same in all channels of each segment
  bool isotropic = false;  ///< whether all g are 0
  SegmentBounds bounds;
};

/// Work done, in pairs of photon or piece and segment (without padding) and in vector steps.
struct VolumeCounts {
  std::uint64_t tested = 0;     ///< pairs whose distance was computed
  std::uint64_t evaluated = 0;  ///< of these, pairs within the radius
  std::uint64_t steps = 0;      ///< a photon against a vector of segments
};

/// Working lists of a call, kept for the next call; for one thread only.
struct VolumeScratch {
  std::vector<std::uint32_t> above, blocks, list;
};

/// Sums the photons or beams at each segment of the tile (runs on the instruction set of set_simd()). The sum of a
/// segment is added in the order of the tree: the same bits for any other segments in the tile.
///
/// Photons add (1 - d^2 / r^2) T flux, at distance d from the segment: nothing behind their walls, and before them also
/// what mirror images across one wall or both would add there, or their share of a narrow gap (kNarrowGap). Beams add
/// the integral of that over the part of the segment which lies in the tube of the piece, with T to second order: a
/// full crossing at distance u and angle theta has the kernel's integral 4 / 3 (1 - u^2 / r^2)^1.5 r / sin(theta), the
/// projection of the same kernel.
void sum_volume(const VolumeTree& tree, SegmentTile& tile, VolumeScratch& scratch, VolumeCounts& counts);

}  // namespace glowworm
