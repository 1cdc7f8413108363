#include "points/finite_light.h"

#include <cmath>

namespace glowworm {

namespace {

// NaN compares as false.
bool is_bounded(RGB light) {
  return std::abs(light.r) <= kMaxRadiance && std::abs(light.g) <= kMaxRadiance && std::abs(light.b) <= kMaxRadiance;
}

}  // namespace

std::size_t drop_infinite_samples(SlotRadiance& radiance) {
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < radiance.emitted.size(); ++i) {
    if (is_bounded(radiance.emitted[i]) && is_bounded(radiance.direct[i]) && is_bounded(radiance.indirect[i]) &&
        is_bounded(radiance.caustic[i]) &&
        (radiance.surface_emitted.empty() || is_bounded(radiance.surface_emitted[i])) &&
        (radiance.medium.empty() || is_bounded(radiance.medium[i])))
      continue;
    radiance.emitted[i] = radiance.direct[i] = radiance.indirect[i] = radiance.caustic[i] = RGB();
    if (!radiance.surface_emitted.empty()) radiance.surface_emitted[i] = RGB();
    if (!radiance.sun.empty()) radiance.sun[i] = RGB();
    if (!radiance.medium.empty()) radiance.medium[i] = RGB();
    for (auto& group : radiance.groups) group[i] = RGB();
    ++dropped;
  }
  return dropped;
}

}  // namespace glowworm
