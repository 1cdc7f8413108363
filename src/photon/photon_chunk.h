// Light paths of a photon pass, a chunk at a time. For photon_tracer.cc alone.
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/large_array.h"
#include "photon/diffuse_hits.h"
#include "photon/photon_tracer.h"

namespace glowworm {

inline constexpr std::size_t kPathsPerChunk = 1024;

/// What a chunk of paths leaves. Arrays of photons hold `count`, and have room for more; they are in order of bounce.
struct PhotonChunk {
  std::size_t count = 0;  ///< photons
  LargeArray<Vec3> position, direction, normal;
  LargeArray<RGB> flux;              ///< as emitted, not divided by the number of paths
  LargeArray<std::uint32_t> light;   ///< source, counted as in Scene::light_power()
  LargeArray<std::uint32_t> path;    ///< counted from 0 within the chunk; written in pilot passes alone
  LargeArray<std::uint8_t> caustic;  ///< every bounce before was sharp, and there was one
  LargeArray<std::uint8_t> used;     ///< at a place that the image asks for; written where there is a demand
  FluxBalance balance;
  std::vector<std::uint32_t> emitted_light;  ///< of each path; kNone where there is no light
  std::vector<EmissionNumbers> numbers;      ///< that each path was emitted with; empty but in pilot passes
  std::vector<float> guide_weight;           ///< and the factor on its flux; likewise

  /// Makes room for so many photons.
  void make_room(std::size_t most);
};

/// What all chunks of a pass share.
struct PhotonChunkSettings {
  const Tracer* tracer = nullptr;
  const PhotonPassSettings* pass = nullptr;
  bool pilot = false;  ///< emission numbers and paths of photons are kept
};

/// How much the image asks for a photon: of the global map and, where it is one, of the caustic map.
float demand_for(const PhotonDemand& demand, Vec3 position, Vec3 normal, bool caustic);

/// Traces chunks of paths, on any number of threads at once.
class ChunkTracers {
 public:
  /// What `settings` points to must outlive this.
  explicit ChunkTracers(const PhotonChunkSettings& settings);
  ~ChunkTracers();
  ChunkTracers(const ChunkTracers&) = delete;
  ChunkTracers& operator=(const ChunkTracers&) = delete;

  /// Traces paths [first, first + count) of a pass on the calling thread, count <= kPathsPerChunk. What the chunk held
  /// before is gone, its memory is used again.
  void trace(std::uint64_t first, std::size_t count, PhotonChunk& chunk);

 private:
  class ChunkTracer;

  const PhotonChunkSettings settings_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<ChunkTracer>> idle_;  // their arrays serve the next chunk
};

}  // namespace glowworm
