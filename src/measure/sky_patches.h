// Daylight coefficients: what each patch of the sky contributes to sensors.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "measure/sensors.h"
#include "render/settings.h"
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
  /// Light of radiance 1 W sr^-1 m^-2 from a patch: a table of 0.5 degrees whose texels at edges hold their share, so
  /// that all patches together are the same all around.
  Environment light(std::size_t patch) const;

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

/// Measures all patches, one render for each: the scene's own lights are off.
/// @param done called with the number of patches so far; it may throw Cancelled
DaylightMatrix measure_sky_patches(const Scene& scene, const Sensors& sensors, bool on_surfaces,
                                   const SkyPatches& patches, const RenderSettings& settings,
                                   const std::function<void(std::size_t)>& done);

/// The matrix as rfluxmtx and rcontrib write it in ASCII: a row of R G B triples for each sensor, with the columns in
/// the order of patches; dctimestep multiplies it by the vectors of gendaymtx.
std::string daylight_matrix_text(const DaylightMatrix& matrix, const std::string& about);

}  // namespace glowworm
