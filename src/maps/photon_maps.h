// The photon maps of renders, sessions and measurements: traced, measured and indexed in steps.
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>

#include "core/memo.h"
#include "core/memory_budget.h"
#include "core/statistics.h"
#include "density/engine.h"
#include "gather/bright_patches.h"
#include "gather/radius_grid.h"
#include "maps/air_light.h"
#include "maps/indexed_map.h"
#include "maps/volume_maps.h"
#include "photon/photon_tracer.h"

namespace glowworm {

/// Which maps to make. The lights are not part of it: call PhotonMaps::forget() when they change.
struct PhotonMapSettings : IndexInputs {  // of the global map
  float caustic_radius = 0;               ///< as `radius`, of the caustic map
  /// Decides which photons count as used; null: all.
  std::shared_ptr<const PhotonImportance> importance;

  // Steps that a moving view may leave out, beside the correction. Finished steps stay.
  bool secondary_gather = false;  ///< make PhotonMaps::radii()
  bool patches = false;           ///< make PhotonMaps::bright_patches()
  /// Paths that may be emitted, towards what makes caustics, for a caustic map of more photons; 0: none.
  std::uint64_t more_caustic_paths = 0;

  bool diagnosed = false;                       ///< an index that counts photons, for false colours
  bool air_extrapolates = false;                ///< AirLight::extrapolates
  bool narrow = false, narrow_caustic = false;  ///< make PhotonMaps::narrow(), narrow_caustic()
  bool sampled = false;                         ///< make PhotonMaps::sample(), caustic_sample() and signed_media()
  /// Keep the photons beside the engines' indices, so that new radii, kernels and engines need no new tracing.
  bool kept = true;
  /// Memory for light paths that are kept for the map of another moment of the scene (photon/kept_paths.h): after
  /// forget(), that traces those alone that changed; 0: none are kept.
  std::uint64_t most_kept_bytes = 0;
  /// Processes that divide the work; null: none.
  SharedWork* shared = nullptr;
};

/// Sums of the diagnosing index for a query point of Lambertian reflectance pi: r photons per m^2, g the same times
/// their radii, b shader operations.
struct PhotonDiagnosis {
  float density = 0;            ///< photons per m^2
  float mean_radius = 0;        ///< metres; 0 if there is no photon
  float shader_operations = 0;  ///< photons within their radius
};
PhotonDiagnosis photon_diagnosis(RGB sum);

/// Bounces of a photon path if a light path has at most `max_bounces`: the lookup adds the rest of the path.
inline int photon_bounces(int max_bounces) { return max_bounces > 2 ? max_bounces - 1 : 1; }

/// Factor on the radii in a pass of progressive photon mapping: r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1) (Knaus and
/// Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", 2011, equation 20), with alpha = 2/3.
float progressive_radius_scale(std::uint32_t pass);

/// Value for PhotonMapSettings::more_caustic_paths if a camera sample of all pixels has so many gather rays: tracing
/// these paths takes a small part of a render with kDefaultSamples.
std::uint64_t affordable_caustic_paths(double gather_rays);

/// Global and caustic map with the engines over them. update() redoes only the steps whose input changed.
class PhotonMaps {
 public:
  /// @param budget must outlive the maps; they reserve their memory in it as "photon map"
  explicit PhotonMaps(MemoryBudget& budget) : budget_(&budget) {}

  /// Makes the maps for these settings; does nothing if they are up to date. Runs on all threads; the maps do not
  /// depend on their number. Throws Cancelled within an interrupted CancellationScope, and Error if the budget is too
  /// small; finished steps are kept.
  void update(const Tracer& tracer, const PhotonMapSettings& settings, Statistics& statistics);
  /// Discards everything but light paths that are kept. Call it when the scene or the lights have changed.
  void forget();
  /// Moves the reservation of the maps to another budget; null: none, until the next call. Throws Error if that budget
  /// is too small.
  void reserve_in(MemoryBudget* budget);

  bool empty() const { return global_.count() == 0; }
  /// Whether update() has traced the photons and builds the map; any thread may ask.
  bool is_building() const { return *building_; }
  /// Photons in the global map, and in the caustic map.
  std::size_t global_count() const { return global_.count(); }
  /// Engines over the global map: one, or one for each group of lights, whose sums are the light of all.
  using Engines = IndexedMap::Engines;
  const Engines& engines() const { return global_.engines(); }
  /// The same over the caustic map; empty if there are no caustics.
  const Engines& caustic_engines() const { return caustic_.engines(); }
  /// Maps of the photons in media, in groups as engines(); without groups where the scene has no media.
  const VolumeMaps& in_media() const { return media_maps_->all; }
  /// MediaMaps::signed_sample; empty without PhotonMapSettings::sampled.
  const VolumeMaps& signed_media() const { return media_maps_->signed_sample; }
  /// Photons that pass PhotonMapSettings::in_air.
  const AirLight& air() const { return air_; }
  /// Engines over the same photons with kernels of half the area, for estimates of the bias; empty where they are not
  /// wanted, and where there are no photons.
  const Engines& narrow() const { return global_.narrow(); }
  const Engines& narrow_caustic() const { return caustic_.narrow(); }
  /// A few of the photons, which tell their noise (maps/photon_noise.h); empty without PhotonMapSettings::sampled.
  const PhotonSample& sample() const { return global_.sample(); }
  const PhotonSample& caustic_sample() const { return caustic_.sample(); }
  /// The engine over counts instead of flux; null without PhotonMapSettings::diagnosed.
  const DensityEngine* diagnosis() const { return diagnosis_->get(); }
  /// The radius of all photons of the global map, metres; 0 without PhotonMapSettings::fixed_radius.
  float common_radius() const { return common_radius_; }
  /// Radii by place, for the secondary gather; empty without PhotonMapSettings::secondary_gather.
  const RadiusGrid& radii() const { return *radius_grid_; }
  /// Targets of extra gather rays; empty without PhotonMapSettings::patches.
  const BrightPatches& bright_patches() const { return *patches_; }
  /// Corrects what an engine over the global map, or narrow(), found at points. Does nothing without
  /// BoundaryCorrection::estimates.
  void correct(const Tracer& tracer, const QueryPoints& points, std::span<RGB> radiance, bool is_narrow = false) const;
  /// Positions of the photons of the global map, metres.
  const Box3& bounds() const { return bounds_; }
  /// Counts and flux balance of the pass. Its photon batches are empty.
  const PhotonPass& pass() const { return pass_; }
  /// Bytes of the photons, without the engines' indices.
  std::uint64_t bytes() const {
    return (global_.count() + caustic_.count()) * (bytes_each<PhotonBatch>() + sizeof(float));
  }

 private:
  bool is_done() const;
  PhotonInputs photon_inputs(const IndexedMap& map) const;
  IndexInputs inputs_of(const IndexedMap& map) const;
  bool finds_radii() const { return settings_.secondary_gather || settings_.patches; }
  void trace(const Tracer& tracer, Statistics& statistics);
  PhotonPass trace_all(const Tracer& tracer, PhotonPassSettings pass, Statistics& statistics);
  void trace_air(const Tracer& tracer, PhotonPassSettings pass, Statistics& statistics);
  PhotonPass trace_chosen(const Tracer& tracer, PhotonChoice choice, const DiscTree* discs, Statistics& statistics);
  /// Returns the largest radii of caustic photons; null: there are none, or all have one radius.
  std::unique_ptr<const QueryRadii> bring_up_global(const MapWork& work);
  void bring_up_sides(const Tracer& tracer, Statistics& statistics);
  void bring_up_caustic(const MapWork& work, const QueryRadii* widest);
  void bring_up_media(const MapWork& work);
  std::uint64_t wanted_caustic_paths() const;
  std::uint32_t caustic_nearest() const;
  void add_caustic_photons(const Tracer& tracer, Statistics& statistics);
  BrightPatches find_patches(const Tracer& tracer) const;
  std::unique_ptr<DensityEngine> diagnose(const KernelInputs& inputs, Statistics& statistics) const;
  PhotonPassSettings pass_settings() const;
  void hold_result();

  MemoryBudget* budget_;
  std::unique_ptr<Reservation> reservation_;
  std::shared_ptr<KeptPaths> kept_paths_;  // null: none yet
  std::unique_ptr<Reservation> kept_room_;
  PhotonMapSettings settings_;
  std::unique_ptr<std::atomic<bool>> building_ = std::make_unique<std::atomic<bool>>(false);  // so that maps move
  PhotonPass pass_;
  IndexedMap global_{"global"}, caustic_{"caustic"};
  Memo<PhotonInputs, LitSides> lit_sides_;  // empty where no kernel is corrected
  Memo<PhotonInputs, MediaPhotons> media_photons_;
  Memo<IndexInputs, MediaMaps> media_maps_;
  float common_radius_ = 0;  // of the global map
  AirLight air_;
  Memo<PhotonSource, std::shared_ptr<const EmissionGuide>> surface_guide_, air_guide_;  // of trace_chosen()
  std::size_t first_caustic_ = 0;    // photons of the caustic map from the pass of the global map
  std::uint64_t caustic_paths_ = 0;  // paths emitted, or enough, for the caustic map alone
  Memo<KernelInputs, std::unique_ptr<DensityEngine>> diagnosis_;
  Memo<ReachInputs, RadiusGrid> radius_grid_;
  Memo<ReachInputs, BrightPatches> patches_;
  Box3 bounds_;
};

}  // namespace glowworm
