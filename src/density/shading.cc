#include "density/shading.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"

namespace glowworm {

void check_policy(const PhotonBatch& photons, const RadiusPolicy& policy, const char* without_nearest) {
  const auto usable = [](float radius) { return std::isfinite(radius) && radius >= 0; };
  switch (policy.kind) {
    case RadiusKind::nearest:
      if (without_nearest)
        throw Error(fmt::format("the {} density engine cannot take the k nearest photons", without_nearest),
                    "Use --engine knn, or a radius for each photon.");
      if (policy.k == 0) throw Error("a k-nearest density estimate needs at least one photon (k is 0)");
      if (!usable(policy.max_radius)) throw Error(fmt::format("invalid maximal photon radius {}", policy.max_radius));
      break;
    case RadiusKind::fixed:
      if (!usable(policy.radius)) throw Error(fmt::format("invalid photon radius {}", policy.radius));
      break;
    case RadiusKind::per_photon:
      if (policy.radii.size() != photons.size()) {
        throw Error(fmt::format("{} radii were given for {} photons", policy.radii.size(), photons.size()));
      }
      for (const float radius : policy.radii) {
        if (!usable(radius)) throw Error(fmt::format("invalid photon radius {}", radius));
      }
      break;
  }
}

RGB BatchShader::shade(const QueryBsdf& query, const GatheredPhotons& photons) {
  std::array<double, 3> sum{};
  add(query, photons, sum);
  return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
}

void BatchShader::add(const QueryBsdf& query, const GatheredPhotons& photons, std::array<double, 3>& sum) {
  const auto local = [&](Vec3 w) { return Vec3{dot(w, query.s), dot(w, query.t), dot(w, query.n)}; };
  const std::size_t count = photons.direction.size();
  local_.resize(count);
  values_.resize(count);
  for (std::size_t i = 0; i < count; ++i) local_[i] = local(photons.direction[i]);
  evaluate_batch(query.bsdf, local(query.wo), local_, query.lobes, values_);
  for (std::size_t i = 0; i < count; ++i) {
    const RGB f = photons.flux[i] * values_[i];
    sum[0] += f.r;
    sum[1] += f.g;
    sum[2] += f.b;
  }
}

}  // namespace glowworm
