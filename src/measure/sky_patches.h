// Daylight coefficients: what each patch of the sky contributes to sensors.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "control/job.h"
#include "measure/matrix_file.h"
#include "scene/scene.h"

namespace glowworm {

/// The patches of Tregenza's sky (145), or Reinhart's of half the size (577), in the order of Radiance's reinhart.cal:
/// 0 is the ground, then rows upwards from the horizon, each from north (-z) on towards east (x). y is up.
class SkyPatches {
 public:
  /// @param patches without the ground: 145 or 577; throws Error for others
  explicit SkyPatches(int patches);
  /// Patches with the ground.
  std::size_t size() const { return size_; }
  /// The patch that a direction lies in.
  std::size_t patch_of(Vec3 direction) const;

  /// A piece of a patch of the sky.
  struct Piece {
    std::size_t patch;
    Vec3 direction;          ///< unit, to its middle
    double solid_angle = 0;  ///< sr
    double projected = 0;    ///< solid angle times cosine, on a horizontal plane
  };
  /// All patches of the sky in pieces, for quadrature; their solid angles are exact.
  /// @param across pieces of a patch along either side
  std::vector<Piece> pieces(int across) const;

 private:
  std::vector<int> in_row_;  // patches of each row, from the horizon on
  double row_height_ = 0;    // radians
  std::size_t size_ = 1;
};

/// The scene under a sky and ground of radiance 1 W sr^-1 m^-2, each patch a light source of its own
/// (EnvironmentParts). The scene's own lights are off.
Scene scene_under_patches(const Scene& scene, const SkyPatches& patches);
/// The scene under suns: directional lights of irradiance 1 W m^-2. The sky is black and the scene's own lights are
/// off.
/// @param suns directions towards them
Scene scene_under_suns(const Scene& scene, std::span<const Vec3> suns);

/// PointGrid::batches of such sensors. A matrix states no errors, and stratified samples help most where patches are
/// seen directly.
inline constexpr std::uint32_t kPatchBatches = 2;

/// The settings of a Job over scene_under_patches() that keeps the light of patches apart, in one pass for all of them.
RenderSettings patch_settings(RenderSettings settings);

/// The daylight matrix of such a Job over sensor_grid(), means over its samples so far: irradiance at sensors (rows)
/// for a radiance of 1 W sr^-1 m^-2 of each patch (columns). rfluxmtx writes the same matrix, and dctimestep multiplies
/// it by those of gendaymtx.
ColorMatrix daylight_matrix(const Job& job, std::size_t sensors);

/// The same of a Job over scene_under_suns(): irradiance for a normal irradiance of 1 W m^-2 of each sun (columns).
ColorMatrix sun_matrix(const Job& job, std::size_t sensors, std::size_t suns);

}  // namespace glowworm
