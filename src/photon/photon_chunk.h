// The photons of a chunk of light paths.
#pragma once
#include <cstdint>
#include <vector>

#include "core/large_array.h"
#include "photon/photon_tracer.h"

namespace glowworm {

inline constexpr std::size_t kPathsPerChunk = 1024;

/// Photons of a chunk of paths. The arrays hold `count` photons and may be longer; photons are in order of bounce.
struct PhotonChunk {
  std::size_t count = 0;  ///< photons
  LargeArray<Vec3> position, direction, normal;
  LargeArray<RGB> flux;                     ///< as emitted, not divided by the number of paths
  LargeArray<std::uint32_t> light;          ///< source, counted as in Scene::light_power()
  LargeArray<std::uint32_t> path;           ///< index of the path in the chunk; only if the tracer needs it
  LargeArray<std::uint8_t> caustic;         ///< as in PhotonPass::caustic
  LargeArray<std::uint8_t> used;            ///< whether the image needs the place; only with a PhotonImportance
  std::vector<PhotonSegment> segments;      ///< as in PhotonPass::segments, with flux as emitted
  std::vector<std::uint32_t> segment_path;  ///< index of the path in the chunk; only in pilot passes
  VolumePhotons in_media;                   ///< as in PhotonPass, with flux as emitted
  VolumeBeams beams;
  FluxBalance balance;
  std::vector<std::uint32_t> emitted_light;  ///< of each path; kNone if there is no light
  std::vector<EmissionNumbers> numbers;      ///< emission numbers of each path; only in pilot passes
  std::vector<float> guide_weight;           ///< the factor on its flux; only in pilot passes

  /// Allocates memory for so many photons.
  void make_room(std::size_t most);
  /// What a pass takes of the chunk (core/archive.h).
  template <typename Archive>
  void transfer(Archive& archive);
  /// Whether the scene can have such a chunk.
  bool is_possible(const Scene& scene) const;
};

}  // namespace glowworm
