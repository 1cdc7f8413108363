#include "points/photon_batch.h"

namespace glowworm {

void PhotonBatch::append(const PhotonBatch& other) {
  position.insert(position.end(), other.position.begin(), other.position.end());
  direction.insert(direction.end(), other.direction.begin(), other.direction.end());
  flux.insert(flux.end(), other.flux.begin(), other.flux.end());
  normal.insert(normal.end(), other.normal.begin(), other.normal.end());
}

PhotonBatch PhotonBatch::permuted(std::span<const std::uint32_t> order) const {
  PhotonBatch out;
  out.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    out.position[i] = position[order[i]];
    out.direction[i] = direction[order[i]];
    out.flux[i] = flux[order[i]];
    out.normal[i] = normal[order[i]];
  }
  return out;
}

Box3 PhotonBatch::bounds() const {
  Box3 box;
  for (const Vec3& p : position) box.grow(p);
  return box;
}

RGB PhotonBatch::total_flux() const {
  double r = 0, g = 0, b = 0;
  for (const RGB& f : flux) {
    r += f.r;
    g += f.g;
    b += f.b;
  }
  return {static_cast<float>(r), static_cast<float>(g), static_cast<float>(b)};
}

}  // namespace glowworm
