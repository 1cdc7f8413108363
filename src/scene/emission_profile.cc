#include "scene/emission_profile.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/content_hash.h"
#include "core/error.h"

namespace glowworm {

EmissionProfile::EmissionProfile(std::shared_ptr<const IntensityTable> table, std::vector<Vec3> faces, bool two_sided)
    : table_(std::move(table)), faces_(std::move(faces)), two_sided_(two_sided) {
  double area = 0;
  for (const Vec3 face : faces_) area += length(face);
  if (!(table_->integral() > 0 && area > 0)) throw Error("a luminous opening has no intensity or no area");
  scale_ = static_cast<float>(M_PI * area * (two_sided ? 2 : 1) / table_->integral());
  ContentHash hash;
  hash.add(table_->hash());
  hash.add_array(std::span<const Vec3>(faces_));
  hash.add(two_sided_);
  hash_ = hash.value();
}

float EmissionProfile::relative_radiance(Vec3 direction) const {
  float area = 0;
  for (const Vec3 face : faces_) {
    const float projected = dot(face, direction);
    area += two_sided_ ? std::abs(projected) : std::max(projected, 0.0f);
  }
  const float radiance = area > 0 ? scale_ * table_->intensity(direction) / area : 0.0f;
  return std::isfinite(radiance) ? radiance : 0.0f;
}

}  // namespace glowworm
