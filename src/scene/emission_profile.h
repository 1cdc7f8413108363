// How the radiance of a luminaire's opening depends on direction.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "core/vec.h"
#include "scene/intensity_table.h"

namespace glowworm {

/// The radiance of a convex opening whose faces all look alike from each direction: the table's intensity in that
/// direction over the projected area of the faces that shine there. Far away, the opening then has exactly the
/// intensities of the table. Directions are unit, in the luminaire's axes (IntensityTable).
class EmissionProfile {
 public:
  /// @param table with an integral above 0
  /// @param faces unit normals times areas; faces of one plane may be joined
  /// @param two_sided the faces shine on both sides
  EmissionProfile(std::shared_ptr<const IntensityTable> table, std::vector<Vec3> faces, bool two_sided);

  /// Radiance towards a direction, over the radiance of an even emission with the same flux; 0 where no face shines.
  float relative_radiance(Vec3 direction) const;
  /// A direction with a density in proportion to the intensity. @param u in [0, 1)
  Vec3 sample(Vec2 u) const { return table_->sample(u); }
  /// The greatest intensity over the flux, sr^-1.
  float peak() const { return static_cast<float>(table_->greatest() / table_->integral()); }
  const IntensityTable& table() const { return *table_; }
  /// A hash of everything above.
  std::uint64_t hash() const { return hash_; }

 private:
  std::shared_ptr<const IntensityTable> table_;
  std::vector<Vec3> faces_;
  bool two_sided_;
  float scale_ = 0;  // pi times the area of all sides that shine, over the table's integral
  std::uint64_t hash_ = 0;
};

}  // namespace glowworm
