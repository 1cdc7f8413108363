// The photons of a chunk of light paths.
#pragma once
#include <algorithm>
#include <compare>
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

/// Which path of a chunk left something, and behind how many surfaces.
struct PlaceOnPath {
  std::uint32_t bounce = 0;
  std::uint16_t path = 0;
  auto operator<=>(const PlaceOnPath&) const = default;
};

/// A straight part of a path, from where the part before ends.
struct PathPart {
  /// Bits of `in_path`: it leaves the scene; the path goes on from where the part starts, but depends on the part.
  static constexpr std::uint32_t kEscapes = 0x80000000u, kAside = 0x40000000u;

  Vec3 end;                   ///< the direction, if it leaves the scene
  std::uint32_t in_path = 0;  ///< path(), and bits

  /// In the chunk.
  std::uint16_t path() const { return static_cast<std::uint16_t>(in_path & ~(kEscapes | kAside)); }
  bool escapes() const { return (in_path & kEscapes) != 0; }
  bool is_aside() const { return (in_path & kAside) != 0; }
};

/// What the paths of a chunk leave, as KeptPaths keep it: photons in order of bounces, then of paths.
struct PathPhotons {
  std::vector<PathPart> parts;  ///< only in passes that keep paths
  std::vector<ChunkPhoton> photons;
  VolumePhotons in_media;  ///< as in PhotonPass, with flux as emitted
  std::vector<PlaceOnPath> in_media_place;
  VolumeBeams beams;
  std::vector<PlaceOnPath> beam_place;

  std::uint64_t bytes() const;
  /// Photons of all maps: of points and beams, a medium's map keeps one.
  std::uint64_t count() const { return photons.size() + std::max(beams.size(), in_media.size()); }
};

/// Photons of a chunk of paths.
struct PhotonChunk : PathPhotons {
  std::vector<PhotonSegment> segments;      ///< as in PhotonPass::segments, with flux as emitted
  std::vector<std::uint32_t> segment_path;  ///< index of the path in the chunk
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
