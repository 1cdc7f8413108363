#include "points/photon_batch.h"

#include <array>
#include <numeric>

#include "core/hilbert.h"

namespace glowworm {

PhotonBatch PhotonBatch::moved(std::span<const std::uint32_t> places) const {
  // First to the part of the result that has the place, then to the place: writes go to few pages at a time, which may
  // be of 2 MB.
  constexpr std::uint64_t kParts = 64;
  const std::uint64_t n = places.size();
  std::array<std::uint32_t, kParts> next;
  for (std::uint64_t part = 0; part < kParts; ++part)
    next[part] = static_cast<std::uint32_t>((part * n + kParts - 1) / kParts);
  std::vector<std::uint32_t> coarse(n), fine(n);
  for (std::size_t i = 0; i < n; ++i) {
    coarse[i] = next[places[i] * kParts / n]++;
    fine[coarse[i]] = places[i];
  }
  PhotonBatch out;
  for_arrays([&](auto& to, const auto& from) { to = glowworm::moved(glowworm::moved(from, coarse), fine); }, out,
             *this);
  return out;
}

Box3 PhotonBatch::bounds() const {
  Box3 box;
  for (const Vec3& p : position) box.grow(p);
  return box;
}

std::vector<std::uint32_t> places_by_cell(std::span<const Vec3> points) {
  constexpr int kBits = 4;
  Box3 box;
  for (const Vec3& p : points)
    if (is_finite(p)) box.grow(p);
  const CubeGrid grid(box, kBits);
  std::vector<std::uint32_t> places(points.size());
  parallel_for_each(points.size(), 4096, [&](std::size_t i) {
    places[i] = static_cast<std::uint32_t>(hilbert_key_of_morton(grid.morton(points[i]), kBits));
  });
  std::array<std::uint32_t, 1 << 3 * kBits> next{};
  for (const std::uint32_t cell : places) ++next[cell];
  std::exclusive_scan(next.begin(), next.end(), next.begin(), 0u);
  for (std::uint32_t& place : places) place = next[place]++;
  return places;
}

}  // namespace glowworm
