// A photon map whose photons belong to groups, such as lights: one search finds the light of each group.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/statistics.h"
#include "density/blocked_index.h"
#include "density/engine.h"

namespace glowworm {

/// The sums of a DensityEngine, apart for each group of photons. A search for each point costs more than the engine's
/// for runs of points, but does not grow with the number of groups.
class GroupedMap {
 public:
  /// Groups from which one search costs less than an engine for each.
  static constexpr std::size_t kLeastGroups = 32;

  /// @param flux of the photons, W @param policy fixed or per_photon @param group_of of each photon
  GroupedMap(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy,
             std::span<const std::uint32_t> group_of);

  /// Adds factor times weight times radiance of each point to light[group][QueryPoints::gather_point], on all threads
  /// (Phase::density; counts query_points, pairs_tested, shader_operations). The sums of a target have the order of its
  /// points, so they do not depend on the number of threads.
  void add(const QueryPoints& points, std::span<std::vector<RGB>> light, Statistics& statistics,
           float factor = 1) const;

  /// Bytes of a map of so many photons.
  static std::uint64_t bytes(std::size_t photons);

 private:
  BlockedIndex index_;
  std::vector<std::uint32_t> group_of_place_;
};

}  // namespace glowworm
