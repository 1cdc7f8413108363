// Light paths that hit diffuse surfaces, as arrays for the kernel.
#pragma once
#include <cstdint>
#include <span>

#include "core/rgb.h"
#include "core/vec.h"
#include "kernels/diffuse_scatter.h"
#include "scene/scene.h"
#include "trace/tracer.h"

namespace glowworm {

/// A block of paths for the kernel. Its arrays fit the first-level cache.
class DiffuseHits {
 public:
  static constexpr std::size_t kBlock = 128;

  /// @param on_black paths leave photons on black surfaces, too, and end there
  explicit DiffuseHits(bool on_black = false) : on_black_(on_black) {}

  /// Scatters paths [first, first + count) of those that have rays, count <= kBlock; path `first` is number 0 of the
  /// block. Paths without a hit leave no photon.
  /// @param paths the flux of all paths, their roulette and their square; the padding is read
  void scatter(const Scene& scene, std::span<const Ray> rays, std::span<const Hit> hits, std::size_t first,
               std::size_t count, const ArrivedPaths& paths);

  /// All bits if path i hit nothing, else none.
  const std::uint32_t* missed() const { return missed_; }
  /// Whether path i hit a surface that the kernel does not support. put() stores its outcome.
  bool left_over(std::size_t i) const { return other_[i] != 0; }
  void put_photon(std::size_t i, Vec3 position, Vec3 normal, RGB flux);
  /// The direction of the photon, as in back().
  void put_back(std::size_t i, Vec3 back);
  void put_path(std::size_t i, Vec3 origin, Vec3 direction, RGB flux);
  void put_outcome(std::size_t i, std::uint32_t outcome) { outcome_[i] = outcome; }

  /// Bits of DiffuseOutcome. They say which of the other results are valid; flux() is 0 where a path ends.
  std::uint32_t outcome(std::size_t i) const { return outcome_[i]; }
  Vec3 back(std::size_t i) const { return vector(back_, i); }
  Vec3 position(std::size_t i) const { return vector(position_, i); }
  Vec3 normal(std::size_t i) const { return vector(normal_, i); }
  RGB photon_flux(std::size_t i) const { return {photon_flux_[0][i], photon_flux_[1][i], photon_flux_[2][i]}; }
  Vec3 origin(std::size_t i) const { return vector(origin_, i); }
  Vec3 direction(std::size_t i) const { return vector(direction_, i); }
  RGB flux(std::size_t i) const { return {flux_[0][i], flux_[1][i], flux_[2][i]}; }
  /// One channel of the flux of all paths.
  const float* flux_channel(int channel) const { return flux_[channel]; }

 private:
  using Array = float[kBlock + kDiffuseScatterPadding];
  static Vec3 vector(const Array* arrays, std::size_t i) { return {arrays[0][i], arrays[1][i], arrays[2][i]}; }
  void place(const Scene& scene, std::span<const Hit> hits, std::size_t first, std::size_t count);
  void place_normals(const Geometry& geometry, const Hit* hits, std::size_t count);

  bool on_black_;
  alignas(64) Array corner_[3] = {}, edges_[6] = {}, geometric_[3] = {}, offset_ = {}, vertex_normals_[9] = {},
                    barycentric_[2] = {}, reflectance_[3] = {}, back_[3] = {};
  alignas(64) Array position_[3] = {}, normal_[3] = {}, photon_flux_[3] = {}, origin_[3] = {},
                    direction_[3] = {}, flux_[3] = {};
  alignas(64) std::uint32_t outcome_[kBlock + kDiffuseScatterPadding] = {}, other_[kBlock] = {}, missed_[kBlock] = {};
};

}  // namespace glowworm
