// Walls that kernels end at.
#pragma once
#include <span>
#include <vector>

#include "density/engine.h"
#include "maps/nearby_surface.h"
#include "points/photon_batch.h"
#include "trace/tracer.h"

namespace glowworm {

/// The walls that stand on the surface around a cluster, with surface of the same kind behind them: a floor goes on in
/// the next room. All places are in the cluster's frame (NearbySurface::frame()).
class NearbyWalls {
 public:
  /// Finds the walls of a surface that approach() has found. Knows none where its triangles are too many to copy.
  void find(const NearbySurface& surface, const BoundaryCluster& cluster);

  bool empty() const { return walls_.empty(); }
  /// Whether a triangle is part of a wall that cuts() has found.
  bool cuts_at(std::uint32_t triangle) const;
  /// The half-spaces that bound a kernel: of the nearest wall, and of the nearest wall on this side of it. A wall
  /// counts if it spans the kernel: light passes beside legs of chairs and through doors.
  /// @param position, radius metres
  std::array<KernelCut, 2> cuts(Vec3 position, float radius);

 private:
  /// A triangle of a wall, where it cuts a plane at half the height of the kernels.
  struct Wall {
    Vec3 from, to;  ///< ends of the cut, metres
    Vec3 normal;    ///< unit
    float height;   ///< of the triangle's plane along its normal, metres
    /// Whether surface lies behind the wall for places in front of it (by `normal`), and for those behind it.
    bool hides_behind = false, hides_before = false;
    std::uint32_t triangle;
    bool cuts = false;  ///< cuts() has found it

    float height_of(Vec3 p) const { return dot(normal, p) - height; }
  };
  bool is_coplanar(const Wall& a, const Wall& b) const;
  bool spans(const Wall& wall, Vec3 position, float radius);

  std::vector<Wall> walls_;
  std::vector<Vec3> surface_corners_;
  std::vector<std::array<float, 2>> covered_;  // working memory
  float rounding_ = 0;
};

/// Appends the cuts of a photon's kernel, if it has any. @param cuts in the cluster's frame, which become the world's
void add_cuts(std::uint32_t photon, std::array<KernelCut, 2> cuts, const Frame& frame, std::vector<PhotonCuts>& out);

/// Brings cuts into the order of their photons.
void sort_cuts(std::vector<PhotonCuts>& cuts);

/// Light must not reach through walls by the kernels of photons: where photons are few, their radii are long. Returns
/// the cuts of photons whose kernels reach surface behind a wall, in the order of the photons. A wall is what rises
/// from a surface by half a kernel's radius. Uses all threads; deterministic. @param radii of the kernels, metres
/// @param on_all_surfaces PhotonPassSettings::on_all_surfaces of the photons
std::vector<PhotonCuts> kernel_cuts(const Tracer& tracer, const PhotonBatch& photons, std::span<const float> radii,
                                    bool on_all_surfaces = false);

}  // namespace glowworm
