// Daylight coefficients: what each patch of the sky contributes to sensors.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "control/job.h"
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

 private:
  std::vector<int> in_row_;  // patches of each row, from the horizon on
  double row_height_ = 0;    // radians
  std::size_t size_ = 1;
};

/// Irradiance at sensors for a radiance of 1 W sr^-1 m^-2 of each patch.
struct DaylightMatrix {
  std::size_t sensors = 0, patches = 0;
  std::vector<RGB> coefficient;  ///< a row of patches for each sensor

  RGB at(std::size_t sensor, std::size_t patch) const { return coefficient[sensor * patches + patch]; }
};

/// The scene under a sky and ground of radiance 1 W sr^-1 m^-2, each patch a light source of its own
/// (EnvironmentParts). The scene's own lights are off.
Scene scene_under_patches(const Scene& scene, const SkyPatches& patches);

/// PointGrid::batches of such sensors. A matrix states no errors, and stratified samples help most where patches are
/// seen directly.
inline constexpr std::uint32_t kPatchBatches = 2;

/// The settings of a Job over scene_under_patches() that keeps the light of patches apart, in one pass for all of them.
RenderSettings patch_settings(RenderSettings settings);

/// The matrix of such a Job over sensor_grid(): means over its samples so far.
DaylightMatrix daylight_matrix(const Job& job, std::size_t sensors);

/// The matrix as rfluxmtx and rcontrib write it in ASCII: a row of R G B triples for each sensor, with the columns in
/// the order of patches; dctimestep multiplies it by the vectors of gendaymtx.
std::string daylight_matrix_text(const DaylightMatrix& matrix, const std::string& about);

}  // namespace glowworm
