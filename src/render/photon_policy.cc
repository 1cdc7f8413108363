#include "render/photon_policy.h"

#include <algorithm>
#include <utility>

#include "render/boundary.h"

namespace glowworm {

std::uint32_t caustic_nearest(std::uint32_t nearest) { return std::max<std::uint32_t>(1, nearest / 2); }

RadiusPolicy photon_policy(std::vector<float> radii, const std::string& engine, KernelShape kernel, std::uint32_t k) {
  RadiusPolicy policy;
  policy.kernel = kernel;
  policy.k = std::max<std::uint32_t>(1, k);
  policy.kind = engine_traits(engine).takes_nearest ? RadiusKind::nearest : RadiusKind::per_photon;
  policy.radii = std::move(radii);
  // Where photons are few, the nearest may be in another part of the scene: no estimate reaches further than the
  // widest of the radii that density asks for.
  if (!policy.radii.empty()) policy.max_radius = 2 * *std::max_element(policy.radii.begin(), policy.radii.end());
  return policy;
}

std::vector<float> edge_factors(const Tracer& tracer, const PhotonBatch& photons, RadiusPolicy policy) {
  if (photons.size() == 0) return {};
  policy.kind = RadiusKind::per_photon;
  return boundary_factors(tracer, photons, policy);
}

}  // namespace glowworm
