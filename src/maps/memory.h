// Memory of the arrays of a render, in bytes.
#pragma once
#include <cstdint>

#include "points/gather_points.h"

namespace glowworm {

/// Bytes of a camera sample during its task: its gather point, twice while they are joined, and its light.
/// @param light_groups whose light is kept apart
/// @param values       SlotValues that are kept
/// @param places       whether the triangles of first hits are kept
/// @param surface_samples whether there are such
inline std::uint64_t bytes_per_slot(std::size_t light_groups, int values = 0, bool places = false,
                                    bool surface_samples = false) {
  return 3 * bytes_each<GatherPoints>() + (5 + light_groups) * sizeof(RGB) + 28 +
         static_cast<std::uint64_t>(values) * (sizeof(RGB) + sizeof(float)) +
         (places ? sizeof(std::uint32_t) + sizeof(Vec2) : 0) + (surface_samples ? 3 * sizeof(RGB) : 0);
}
/// Bytes of a query point between its ray and completion: itself, its radiance, and an engine's order of it.
inline constexpr std::uint64_t kBytesPerQuery = 192;
/// Bytes of a photon while photons are traced and maps are made of them.
/// @param media whether the scene has some: a photon then lies on a surface or in a medium, as a point and a beam
/// @param narrow whether there is PhotonMaps::narrow(), too
std::uint64_t bytes_per_photon(bool media, bool narrow);
/// Bytes of a photon in a map beside its batch: radius, place in the order, and factor.
inline constexpr std::uint64_t kBytesBesidePhoton = 2 * sizeof(float) + sizeof(std::uint32_t);
/// Bytes of a thread for its rays.
inline constexpr std::uint64_t kBytesPerThread = std::uint64_t{8} << 20;

/// Bytes of a render by so many photons while it looks for bright patches, besides its photons.
std::uint64_t bright_patch_bytes(std::uint64_t photons);

}  // namespace glowworm
