#include "points/photon_batch.h"

namespace glowworm {

void PhotonBatch::append(const PhotonBatch& other) {
  for_arrays([](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); }, *this, other);
}

PhotonBatch PhotonBatch::permuted(std::span<const std::uint32_t> order) const {
  PhotonBatch out;
  out.resize(order.size());
  for_arrays(
      [&](auto& to, const auto& from) {
        for (std::size_t i = 0; i < order.size(); ++i) to[i] = from[order[i]];
      },
      out, *this);
  return out;
}

Box3 PhotonBatch::bounds() const {
  Box3 box;
  for (const Vec3& p : position) box.grow(p);
  return box;
}

}  // namespace glowworm
