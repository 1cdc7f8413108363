// The guide of gather rays: where around a point they find light.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "bsdf/bsdf.h"
#include "core/frame.h"
#include "core/vec.h"
#include "kernels/diffuse_rays.h"
#include "scene/geometry.h"

namespace glowworm {

/// A density over the unit square, bilinear between the corners of the cells of a grid.
struct GuideTable {
  static constexpr std::size_t kSide = 16;  ///< cells along a side
  float density[kSide + 1][kSide + 1];      ///< at the corners, row by row; the mean over the square is 1
  float columns[kSide + 1][kSide + 1];      ///< integral along a row of corners up to each corner, in cells
  float rows[kSide + 1];                    ///< integral of columns[][kSide] up to each row, in cells

  /// Warps a point of the square so that it has the density of the table; returns 1 over the density there.
  float warp(float& x, float& y) const;
};

/// Gather rays that a guide learns from: `rays_each` for every point, in the order of points.
struct GuideRays {
  std::uint32_t rays_each = 0;
  std::vector<Vec3> position;      ///< of the points, metres
  std::vector<Vec3> normal;        ///< of the points: unit, on the side of the rays
  std::vector<std::uint8_t> cell;  ///< GatherGuide::cell() of each ray
  std::vector<float> light;        ///< luminance that each ray contributes, of any scale
};

/// Gather rays of diffuse reflection map a point of the unit square to a direction. A guide warps the square first, so
/// that more rays go where earlier rays found light that varies, and strata stay strata. Its density is bilinear
/// between the corners of the cells of a grid, because jumps would cost more noise than they save where light is
/// smooth. Each region of positions and normals has a table of its own. A part of the rays is always spread evenly, so
/// that no weight exceeds 1 / kEvenShare. Regions where this would not lower the variance are not guided. Importance
/// sampling from learned histograms is due to Jensen, "Importance Driven Path Tracing Using the Photon Map", EGWR 1995;
/// here rays learn from rays, whose ends look up the photon map.
class GatherGuide {
 public:
  static constexpr int kSide = GuideTable::kSide;  ///< cells of the grid along a side
  static constexpr float kEvenShare = 0.25f;

  GatherGuide() = default;  ///< guides nothing
  explicit GatherGuide(const GuideRays& rays);

  bool empty() const { return tables_.empty(); }
  /// Number of regions that are guided.
  std::size_t size() const { return tables_.size(); }
  /// Share of the variance of gathered light that the guide is expected to take away, the mean over points. Guides of
  /// parts of the rays, tried on the others, tell it.
  double gain() const { return gain_; }
  /// The region of a gather point, or kNone where rays are not guided. @param normal unit, on the side of the rays
  std::uint32_t region(Vec3 position, Vec3 normal) const;
  /// Warps points of the square as their regions say. @param weight set to 1 / density where rays are guided
  /// @param regions of the points, by region()
  void warp(std::span<const std::uint32_t> regions, const DiffuseSquare& square, float* weight) const;

  /// The same for one point. Returns the weight. @param region with a table
  float warp(std::uint32_t region, Vec2& u) const;

  /// The density of warped points, of mean 1. @param region with a table; @param u of the unit square
  float density(std::uint32_t region, Vec2 u) const;

  /// The cell of a point of the unit square.
  static std::uint8_t cell(Vec2 u);
  /// The frame to which the square's directions refer: it depends on the normal alone. @param normal unit
  static Frame frame(Vec3 normal);
  /// Whether rays from a surface are guided: it reflects diffusely, and transmits nothing that is gathered.
  static bool guides(const Bsdf& bsdf) {
    return is_lambertian(bsdf) || (lobes(bsdf) & (kDiffuseReflection | kDiffuseTransmission)) == kDiffuseReflection;
  }

 private:
  static constexpr int kCells = kSide * kSide;
  /// Node of a tree over positions and normals.
  struct Node {
    int axis = -1;                       // 0 to 2: position, 3 to 5: normal; -1: leaf
    float split = 0;                     // values below lie in the first child
    std::uint32_t first = 0, other = 0;  // children; first: table of a leaf, or kNone
  };
  class Learner;

  std::vector<Node> nodes_;
  std::vector<GuideTable> tables_;
  double gain_ = 0;
};

}  // namespace glowworm
