// Traces the light paths of a photon pass, one chunk at a time. Used by photon_tracer.cc only.
#pragma once
#include <cstdint>
#include <vector>

#include "photon/kept_paths.h"
#include "photon/photon_bounce.h"
#include "photon/photon_walk.h"
#include "photon/start_media.h"
#include "transport/path_queue.h"

namespace glowworm {

/// Importance of a photon to the image: as part of the global map, unless the pass has none, and, if it is a caustic
/// photon, of the caustic map. 1 without importance.
float importance_for(const PhotonPassSettings& pass, Vec3 position, Vec3 normal, bool caustic);

/// Traces chunks of paths. Several threads may call it at once.
class ChunkTracer {
 public:
  /// Both must outlive this object. @param pilot keep the emission numbers of paths
  ChunkTracer(const Tracer& tracer, const PhotonPassSettings& pass, bool pilot = false)
      : tracer_(tracer), pass_(pass), pilot_(pilot), media_(tracer), walk_(tracer, pass) {}

  /// Traces paths [first, first + count) of the pass on the calling thread, count <= kPathsPerChunk. Replaces the
  /// contents of the chunk and reuses its memory.
  void trace(std::uint64_t first, std::size_t count, PhotonChunk& chunk) const;

 private:
  void emit(std::uint64_t first, std::size_t in_chunk, std::vector<LightPath>& paths, PhotonChunk& chunk) const;
  void follow(PathQueue<LightPath>& queue, PhotonChunk& chunk) const;
  void follow_changed(KeptChunk& before, PathQueue<LightPath>& queue, std::size_t count, PhotonChunk& chunk) const;
  bool scatter(LightPath& path, const Hit& hit, int bounce, PhotonChunk& chunk) const;
  void store(const LightPath& path, const PhotonBounce& bounce, int number, PhotonChunk& chunk) const;

  const Tracer& tracer_;
  const PhotonPassSettings& pass_;
  const bool pilot_;
  const StartMedia media_;
  const PhotonWalk walk_;
};

}  // namespace glowworm
