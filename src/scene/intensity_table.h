// Intensity of a luminaire by direction, as photometric files have it.
#pragma once
#include <cstdint>
#include <vector>

#include "core/distribution.h"
#include "core/vec.h"

namespace glowworm {

/// The axis around which the azimuth of a table turns. In the axes of a luminaire, z is the way it aims, x points to
/// its right and y up (CIE 121; IES LM-75: goniometers of type C, A and B).
enum class TablePole : std::uint8_t {
  forward,  ///< C: polar angle (gamma) from z; azimuth C from x towards y
  up,       ///< A: polar angle from y; azimuth from z towards x
  right,    ///< B: polar angle from x; azimuth from z towards y
};

/// Factors on all intensities of a luminaire by the angle (radians, ascending) from straight down at which it aims;
/// linear between angles, constant beyond them. Empty: 1.
struct TiltFactors {
  std::vector<float> angles, factors;
};

/// Intensity over a grid of two angles, between whose lines it is linear in each angle; 0 outside the grid.
class IntensityTable {
 public:
  /// @param azimuths radians, ascending, over at most a full turn; one alone: the same all around
  /// @param polar_angles radians, ascending, in [0, pi], two or more
  /// @param values a row of polar_angles.size() for each azimuth, none negative, usually in candela
  /// Throws Error where the angles or values are not that.
  IntensityTable(TablePole pole, std::vector<float> azimuths, std::vector<float> polar_angles,
                 std::vector<float> values, TiltFactors tilt = {});

  /// The table of a luminaire whose y axis is turned round, as a mirror shows it.
  IntensityTable mirrored() const;
  /// The factor on all intensities for a luminaire that aims along `aim` (unit, y up).
  float tilt_factor(Vec3 aim) const;
  /// The intensity in a direction, without the tilt's factor. @param direction unit, in the luminaire's axes
  float intensity(Vec3 direction) const;
  /// A direction (unit, in the luminaire's axes) with a density in proportion to the intensity. @param u in [0, 1)
  Vec3 sample(Vec2 u) const;
  /// The direction of the greatest value, unit, in the luminaire's axes.
  Vec3 brightest() const;
  /// Integral of the intensity over all directions: the flux, lm for a table in candela.
  double integral() const { return integral_; }
  TablePole pole() const { return pole_; }
  /// The greatest value of the table.
  float greatest() const { return greatest_; }
  /// A hash of everything above.
  std::uint64_t hash() const { return hash_; }

 private:
  float value(std::size_t azimuth, std::size_t polar) const { return values_[azimuth * polar_.size() + polar]; }
  double cell_integral(std::size_t azimuth, std::size_t polar) const;
  Vec3 direction(double azimuth, double polar) const;

  TablePole pole_;
  std::vector<float> azimuths_, polar_, values_;
  TiltFactors tilt_;
  Distribution2D cells_;  // a row for each step of azimuth, a column for each step of the polar angle
  double integral_ = 0;
  float greatest_ = 0;
  std::uint64_t hash_ = 0;
};

}  // namespace glowworm
