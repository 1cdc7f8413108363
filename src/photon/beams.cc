#include "photon/beams.h"

#include <algorithm>
#include <cmath>

namespace glowworm {

namespace {

/// Most change of a colour's share of the flux along a beam.
constexpr float kMostChange = 0.1f;
constexpr float kMostBeams = 32;

}  // namespace

void add_beams(const Medium& medium, const PathState& path, MediumSpan span, RGB flux, std::uint32_t source, float u,
               VolumeBeams& beams) {
  const float length = span.last - span.first;
  if (!(length > 0) || !std::isfinite(length)) return;
  const RGB sigma_t = medium.sigma_a + medium.sigma_s;
  if (is_homogeneous(medium)) {
    const float chosen = std::min(max_component(opacity(sigma_t, length)) / kThinOpacity, 1.0f);
    if (!(u < chosen)) return;
    flux *= 1 / chosen;
  }
  const float spread = max_component(sigma_t) - std::min({sigma_t.r, sigma_t.g, sigma_t.b});
  const float count =
      is_homogeneous(medium) ? std::clamp(std::ceil(spread * length / kMostChange), 1.0f, kMostBeams) : 1.0f;
  const float step = length / count;
  for (float i = 0; i < count; ++i) {
    // Of the photons that get as far as the middle of the beam: as sample_medium() weighs them.
    const RGB left = transmittance(sigma_t, (i + 0.5f) * step);
    const RGB there = count > 1 ? flux * left / mean_over_channels(flux, left) : flux;
    beams.push_back(path.ray.origin + path.ray.direction * (span.first + i * step), path.ray.direction, step, there,
                    path.medium.index, source);
  }
}

}  // namespace glowworm
