#include "transport/smooth_lobes.h"

#include <cmath>

namespace glowworm {

SmoothLobes smooth_lobes(const Vertex& vertex) {
  constexpr float kAlmostOne = 0x1.fffffep-1f, kRounding = 1e-5f;
  const ShadedSurface surface = vertex.surface();
  const ScatteredRay first = surface.sample(vertex.wo, 0, {0.5f, 0.5f}, kSharp),
                     last = surface.sample(vertex.wo, kAlmostOne, {0.5f, 0.5f}, kSharp);
  if (!first.valid || !first.delta) return {};
  if (std::abs(first.pdf - 1) < kRounding) return {{first, {}}, 1};
  if (!last.valid || !last.delta || std::abs(first.pdf + last.pdf - 1) >= kRounding) return {};
  return {{first, last}, 2};
}

}  // namespace glowworm
