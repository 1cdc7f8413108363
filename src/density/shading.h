// What engines share when they shade the photons they found: checks of the policy, and query points that are not
// Lambertian.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "density/engine.h"

namespace glowworm {

/// Throws Error where the policy cannot be used with the photons: radii of the wrong number, negative or not finite.
void check_policy(const PhotonBatch& photons, const RadiusPolicy& policy);

/// Photons gathered for one query point, to be shaded at once.
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

/// Shades gathered photons in batches; keeps its scratch arrays, so one belongs to one thread.
class BatchShader {
 public:
  /// Sum over the photons of f_r(x, w_j, w_o) times flux, of the broad lobes; added up in double precision.
  RGB shade(const QueryBsdf& query, const GatheredPhotons& photons);
  /// The same added to `sum`, photon after photon: the same bits however the photons are cut into calls.
  void add(const QueryBsdf& query, const GatheredPhotons& photons, std::array<double, 3>& sum);

 private:
  std::vector<Vec3> local_;
  std::vector<RGB> values_;
};

}  // namespace glowworm
