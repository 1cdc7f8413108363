// Shading of photons for all engines: checks of the policy, and query points that are not Lambertian.
#pragma once
#include <array>
#include <vector>

#include "density/engine.h"

namespace glowworm {

/// Throws Error if the policy does not fit the photons: wrong number of radii, negative or infinite radii.
/// @param without_nearest an engine that cannot take the k nearest photons; null: it can
void check_policy(const PhotonBatch& photons, const RadiusPolicy& policy, const char* without_nearest = nullptr);

/// Photons of one query point, to be shaded at once.
struct GatheredPhotons {
  std::vector<Vec3> direction;  ///< unit, world space, back along the photon's way
  std::vector<RGB> flux;        ///< dPhi_j K(d) / h^2, in W m^-2

  void clear() {
    direction.clear();
    flux.clear();
  }
  void push_back(Vec3 w, RGB weighted_flux) {
    direction.push_back(w);
    flux.push_back(weighted_flux);
  }
};

/// Shades photons in batches; keeps its scratch arrays, so one object belongs to one thread.
class BatchShader {
 public:
  /// Sum over the photons of f_r(x, w_j, w_o) times flux, for the broad lobes, in double precision.
  RGB shade(const QueryBsdf& query, const GatheredPhotons& photons);
  /// Adds the same to `sum`, photon by photon: the result does not depend on how the photons are divided into calls.
  void add(const QueryBsdf& query, const GatheredPhotons& photons, std::array<double, 3>& sum);

 private:
  std::vector<Vec3> local_;
  std::vector<RGB> values_;
};

}  // namespace glowworm
