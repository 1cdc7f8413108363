// A photon map for searches of single query points: normal photon mapping.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "density/engine.h"
#include "density/kd_tree.h"
#include "points/photon_batch.h"

namespace glowworm {

/// A photon that a search found. `place` is its index in the map's order.
struct FoundPhoton {
  float distance_squared;
  std::uint32_t place;
};

/// Places and normals of photons, in the order of the leaves of a kd-tree.
class PhotonPlaces {
 public:
  /// Builds the tree on all threads. @param position, normal of one length @param cuts beyond which photons do not
  /// count
  void build(std::span<const Vec3> position, std::span<const Vec3> normal, std::span<const PhotonCuts> cuts);

  std::size_t size() const { return tree_.points.size(); }
  const KdTree& tree() const { return tree_; }
  /// Index in the batch of the photon at a place.
  std::uint32_t index(std::uint32_t place) const { return tree_.points[place].index; }
  Vec3 normal(std::uint32_t place) const { return normal_[place]; }

  /// The k photons nearest to x whose normals have a dot product with `normal` above min_cosine; fewer if there are
  /// fewer within the limit. In no particular order, except that the farthest comes first if k were found. The place
  /// decides between photons at equal distance.
  /// @param limit_squared square of the largest distance (exclusive), m^2
  /// @param found         scratch of at least k elements; receives the photons
  /// @param tested        increased by the number of photons whose distance was computed
  /// @returns how many were found
  std::size_t nearest(Vec3 x, Vec3 normal, float min_cosine, std::size_t k, float limit_squared,
                      std::span<std::uint64_t> found, std::uint64_t& tested) const;

  /// Unpacks the result of nearest().
  static FoundPhoton unpack(std::uint64_t packed);

  /// All photons of matching normal that are nearer to x than `radius`.
  void within(Vec3 x, Vec3 normal, float min_cosine, float radius, std::vector<FoundPhoton>& found,
              std::uint64_t& tested) const;

 private:
  bool is_cut_off(std::uint32_t place, Vec3 x) const {
    return !cut_of_.empty() && cut_of_[place] > 0 && !cuts_[cut_of_[place] - 1].keep(x - tree_.points[place].position);
  }

  KdTree tree_;
  LargeArray<Vec3> normal_;
  std::vector<std::uint32_t> cut_of_;  // one more than the place in cuts_, or 0; empty without cuts
  std::vector<PhotonCuts> cuts_;
};

/// The photons themselves in that order.
class PhotonMap : public PhotonPlaces {
 public:
  /// Builds the map on all threads. @param flux of the photons, W @param cuts beyond which they do not count
  void build(const PhotonBatch& photons, std::span<const RGB> flux, std::span<const PhotonCuts> cuts);

  Vec3 direction(std::uint32_t place) const { return direction_[place]; }
  RGB flux(std::uint32_t place) const { return flux_[place]; }

 private:
  LargeArray<Vec3> direction_;
  LargeArray<RGB> flux_;
};

}  // namespace glowworm
