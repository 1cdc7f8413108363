// The photons of a chunk of light paths.
#pragma once
#include <cstdint>
#include <vector>

#include "core/large_array.h"
#include "photon/photon_tracer.h"

namespace glowworm {

inline constexpr std::size_t kPathsPerChunk = 1024;

/// A photon on a surface.
struct ChunkPhoton {
  Vec3 position, direction, normal;
  RGB flux;                  ///< as emitted, W: not divided by the number of paths
  std::uint32_t light = 0;   ///< source, counted as in Scene::light_power()
  std::uint32_t bounce = 0;  ///< surfaces before
  std::uint16_t path = 0;    ///< in the chunk
  std::uint8_t caustic = 0;  ///< whether it is part of PhotonPass::caustic
  std::uint8_t used = 0;     ///< whether the image needs the place; only with a PhotonImportance
};

/// Photons of a chunk of paths.
struct PhotonChunk {
  std::vector<ChunkPhoton> photons;         ///< in order of bounces, then of paths
  std::vector<PhotonSegment> segments;      ///< as in PhotonPass::segments, with flux as emitted
  std::vector<std::uint32_t> segment_path;  ///< index of the path in the chunk
  VolumePhotons in_media;                   ///< as in PhotonPass, with flux as emitted
  VolumeBeams beams;
  FluxBalance balance;
  std::vector<std::uint32_t> emitted_light;  ///< of each path; kNone if there is no light
  std::vector<EmissionNumbers> numbers;      ///< emission numbers of each path; only in pilot passes
  std::vector<float> guide_weight;           ///< the factor on its flux; only in pilot passes

  /// Removes all content, but keeps the memory.
  void clear();
  /// What a pass takes of the chunk (core/archive.h).
  template <typename Archive>
  void transfer(Archive& archive);
  /// Whether the scene can have such a chunk.
  bool is_possible(const Scene& scene) const;
};

/// Adds flux to a sum of a FluxBalance.
void add(std::array<double, 3>& sum, RGB flux);

}  // namespace glowworm
