// The photons of reverse photon mapping: the array A_P of [HHS05], in the order of a second kd-tree, and its clusters.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "density/engine.h"
#include "kernels/reverse.h"

namespace glowworm {

/// Photons in A_P order. Photons that no kernel can contain (radius 0, or not finite) are left out.
class ReversePhotonArray {
 public:
  /// @param fluxes       of the photons, W
  /// @param policy       fixed or per_photon
  /// @param cluster_size most photons in a cluster; 1: every photon searches alone
  ReversePhotonArray(const PhotonBatch& photons, std::span<const RGB> fluxes, const RadiusPolicy& policy,
                     std::uint32_t cluster_size);
  ReversePhotonArray() = default;

  /// The view for the kernels; valid until this object is moved or destroyed.
  ReversePhotons view() const;
  std::size_t size() const { return direction_.size(); }
  const std::vector<ReverseCluster>& clusters() const { return clusters_; }
  /// Calls work(cluster) in A_P order for every cluster that may reach into the box.
  void visit(const Box3& box, const std::function<void(const ReverseCluster&)>& work) const;
  /// Unit, back along the path of the photon at a place.
  Vec3 direction(std::uint32_t place) const { return direction_[place]; }
  /// dPhi / h^2 times the norm of the kernel, W m^-2.
  RGB flux(std::uint32_t place) const;

  /// Bytes held for so many photons.
  static std::uint64_t bytes(std::size_t photons);

 private:
  /// A run of clusters, and a box around them.
  struct Group {
    std::uint32_t first, last;
    Box3 bounds;
  };
  enum Field { kX, kY, kZ, kInverse, kNormalX, kNormalY, kNormalZ, kRed, kGreen, kBlue, kFields };

  void make_clusters(const std::vector<float>& radii, std::uint32_t cluster_size);
  ReverseCluster make_cluster(std::uint32_t first, std::uint32_t last, const std::vector<float>& radii) const;
  Vec3 position(std::size_t i) const { return {fields_[kX][i], fields_[kY][i], fields_[kZ][i]}; }

  std::array<std::vector<float>, kFields> fields_;
  std::vector<Vec3> direction_;
  std::vector<ReverseCluster> clusters_;
  std::vector<Group> groups_;
  float min_normal_cosine_ = 0;
  KernelShape kernel_ = KernelShape::epanechnikov;
};

}  // namespace glowworm
