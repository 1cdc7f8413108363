// The radii of the kernels around query points, for corrections that need them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/rgb.h"
#include "density/engine.h"
#include "density/knn.h"

namespace glowworm {

/// Finds the radius of an estimate: the radius of all kernels, or of the nearest photon that counts, or the distance of
/// the last of the k nearest photons.
class QueryRadii {
 public:
  /// @param policy of the engine over these photons; its radii are copied
  QueryRadii(const PhotonBatch& photons, const RadiusPolicy& policy);

  /// Returns a radius in metres for each point; 0 where its light is black, or no photon is near. Uses all threads. The
  /// radius of a point depends on that point alone. @param position, normal, light of one length
  std::vector<float> at(std::span<const Vec3> position, std::span<const Vec3> normal, std::span<const RGB> light) const;

  KernelShape kernel() const { return kernel_; }
  /// Memory for so many photons, at most.
  static std::uint64_t bytes(std::size_t photons);

 private:
  float radius_at(Vec3 x, Vec3 normal, std::span<std::uint64_t> found) const;

  RadiusKind kind_;
  KernelShape kernel_;
  std::uint32_t sought_ = 1;  ///< nearest photons that are looked for
  float radius_ = 0;          ///< fixed: of all kernels; else the largest distance of a photon, 0 if there is none
  float min_normal_cosine_;
  PhotonPlaces places_;
  std::vector<float> radii_;  ///< per_photon: in the order of places
};

}  // namespace glowworm
