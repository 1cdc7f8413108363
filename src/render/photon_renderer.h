// Photon mapping: from a camera task to the light of its slots.
#pragma once
#include <memory>

#include "core/memory_budget.h"
#include "core/statistics.h"
#include "density/engine.h"
#include "density/paged_array.h"
#include "gather/bright_patches.h"
#include "gather/camera_pass.h"
#include "gather/radius_grid.h"
#include "photon/photon_tracer.h"
#include "render/photon_guiding.h"
#include "render/photon_report.h"
#include "render/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// Whether a render has the time to trace photons for its caustic map alone.
bool has_time_for_caustics(const RenderSettings& settings);

/// Holds the photon maps of one photon pass and renders tasks with them. Immutable between calls of shoot_photons().
class PhotonRenderer {
 public:
  /// @param settings resolved; both references must outlive the renderer
  PhotonRenderer(const Tracer& tracer, const RenderSettings& settings, MemoryBudget& budget, Statistics& statistics);
  ~PhotonRenderer();

  /// Traces the photons of a pass and builds their maps. Radii are those that catch settings.nearest photons, times
  /// `radius_scale`.
  void shoot_photons(std::uint32_t pass, float radius_scale);

  /// How many query points of a task are looked up at once, where the budget allows, and whether by way of a file.
  void set_portions(std::size_t queries_at_once, bool by_disk) {
    queries_at_once_ = queries_at_once;
    by_disk_ = by_disk;
  }

  /// Renders one task the whole way: camera pass, direct light, final gather, density estimation, completion.
  void render(const Camera& camera, const CameraTask& task, SlotRadiance& radiance, FirstHit& first_hit);

  /// The name of the engine in use.
  std::string engine() const;
  /// Bytes of the photon maps, without the engine's index.
  std::uint64_t photon_bytes() const;
  /// The pass whose photons are held, with its flux balance; the photons themselves are in the engines alone.
  const PhotonPass& photons() const { return pass_; }
  /// What became of the photons of all passes so far.
  const std::vector<LightPhotons>& light_photons() const { return light_photons_; }
  /// What went through the caches of files with query points.
  const PagedCounts& paged_counts() const { return paged_; }
  /// Most query points that were held at once, in bytes.
  std::uint64_t query_bytes() const { return query_bytes_; }

 private:
  void find_bright_patches();
  /// Makes the map of the pass's caustic photons and of those that more passes bring.
  void build_caustic_map(const PhotonPassSettings& first, float radius_scale);
  /// Traces more photons where few are caustic, and keeps those that are.
  void add_caustic_photons(PhotonPassSettings settings);
  void hold_engines_only();
  void gather(const GatherPoints& points, SlotRadiance& radiance);
  void count_held(const QueryPoints& queries);
  void look_up(const QueryPoints& queries, const DensityEngine& engine, std::vector<RGB>& target);

  const Tracer& tracer_;
  const RenderSettings& settings_;
  MemoryBudget& budget_;
  Statistics& statistics_;
  std::unique_ptr<PhotonGuiding> guiding_;
  PhotonPass pass_;
  std::vector<LightPhotons> light_photons_;
  std::unique_ptr<Reservation> photon_reservation_;
  std::unique_ptr<DensityEngine> engine_, caustic_engine_;
  RadiusGrid radii_;
  BrightPatches bright_;
  QueryPoints queries_;     // of the last portion: their memory is used again
  QueryPoints corners_;     // of rays that gather again, for the caustic map; likewise
  LargeVector<RGB> found_;  // radiance of the query points looked up last; its memory serves the next
  std::uint64_t query_bytes_ = 0, photon_count_ = 0;
  PagedCounts paged_;
  Box3 photon_bounds_;
  std::size_t queries_at_once_ = std::size_t{1} << 22;
  bool by_disk_ = false;
};

}  // namespace glowworm
