// Traces the light paths of a photon pass, one chunk at a time. Used by photon_tracer.cc only.
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "photon/photon_chunk.h"
#include "photon/start_media.h"
#include "transport/sun_images.h"

namespace glowworm {

/// Data that all chunks of a pass share.
struct PhotonChunkSettings {
  const Tracer* tracer = nullptr;
  const PhotonPassSettings* pass = nullptr;
  bool pilot = false;  ///< keep emission numbers and the paths of photons
};

/// Importance of a photon to the image: as part of the global map, unless the pass has none, and, if it is a caustic
/// photon, of the caustic map. 1 without importance.
float importance_for(const PhotonPassSettings& pass, Vec3 position, Vec3 normal, bool caustic);

/// Traces chunks of paths. Several threads may call it at once.
class ChunkTracers {
 public:
  /// The objects that `settings` points to must outlive this one.
  explicit ChunkTracers(const PhotonChunkSettings& settings);
  ~ChunkTracers();
  ChunkTracers(const ChunkTracers&) = delete;
  ChunkTracers& operator=(const ChunkTracers&) = delete;

  /// Traces paths [first, first + count) of a pass on the calling thread, count <= kPathsPerChunk. Replaces the
  /// contents of the chunk and reuses its memory.
  void trace(std::uint64_t first, std::size_t count, PhotonChunk& chunk);

 private:
  class ChunkTracer;

  const PhotonChunkSettings settings_;
  const StartMedia media_;
  /// Directions from which light sources bring no photons to discs, because rays find their images; empty: from none.
  const std::vector<std::vector<Vec3>> images_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<ChunkTracer>> idle_;  // their arrays are reused by the next chunk
};

}  // namespace glowworm
