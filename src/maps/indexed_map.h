// One photon map, global or caustic: its photons, their radii, the correction of their kernels, and engines over them.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/memo.h"
#include "core/shared_work.h"
#include "core/statistics.h"
#include "density/engine.h"
#include "density/grouped_map.h"
#include "density/photon_sample.h"
#include "density/query_radii.h"
#include "density/radius.h"
#include "gather/point_pass.h"
#include "maps/lit_sides.h"
#include "photon/photon_tracer.h"
#include "scene/light_groups.h"
#include "trace/tracer.h"
#include "transport/roulette.h"

namespace glowworm {

/// How kernels that extend over the edge of a surface are corrected (maps/boundary.h).
enum class BoundaryCorrection : std::uint8_t {
  none,
  photons,    ///< factors on the photons' flux: conserves flux, costs nothing for each query point
  estimates,  ///< PhotonMaps::correct() for each query point: for estimates that are seen
};

/// Which photons there are. The scene is not part of it. Pointers are equal if they point to the same object.
struct PhotonSource {
  std::uint64_t photons = 500'000;  ///< in the global map
  std::uint64_t thinned = 0;        ///< how many of them density control leaves; 0: all
  std::uint32_t seed = 0;
  int max_bounces = kNoBounceLimit;  ///< of a photon path
  bool on_all_surfaces = false;      ///< PhotonPassSettings::on_all_surfaces
  /// Guide of the emission; null: in proportion to power.
  std::shared_ptr<const EmissionGuide> guide;
  /// Photons on surfaces. Other choices than all make the caustic map alone, of paths that may be emitted as often as
  /// `photons` says.
  PhotonChoice choice = PhotonChoice::all;
  /// Points in air, for which PhotonMaps::air() is made; null: none. They must not change.
  std::shared_ptr<const PointGrid> in_air;
  PhotonChoice air_choice = PhotonChoice::all;  ///< photons for them
  /// Groups of light sources that get an index each; null: one index.
  std::shared_ptr<const LightGroups> light_groups;

  bool operator==(const PhotonSource&) const = default;
};

/// The photons of a map.
struct PhotonInputs : PhotonSource {
  std::uint32_t pass = 0;            ///< selects the photons
  std::uint32_t nearest_in_air = 0;  ///< AirLight::nearest; 0 without points in air
  std::uint64_t caustic_paths = 0;   ///< emitted for the caustic map alone; all bits set: as many as make a difference

  bool operator==(const PhotonInputs&) const = default;
};

/// Their radii.
struct RadiusInputs : PhotonInputs {
  std::uint32_t nearest = 50;  ///< k: target number of photons in an estimate
  bool fixed_radius = false;   ///< one radius for all photons
  float radius = 0;            ///< that radius, metres; 0: fixed_radius() of the photons

  bool operator==(const RadiusInputs&) const = default;
};

/// The radii of their kernels.
struct ReachInputs : RadiusInputs {
  float radius_scale = 1;  ///< factor on the radii

  bool operator==(const ReachInputs&) const = default;
};

/// Their kernels, and how these are corrected.
struct KernelInputs : ReachInputs {
  KernelShape kernel = KernelShape::epanechnikov;
  bool takes_nearest = false;  ///< EngineTraits::takes_nearest
  BoundaryCorrection correction = BoundaryCorrection::none;

  bool operator==(const KernelInputs&) const = default;
};

/// The engines over them.
struct IndexInputs : KernelInputs {
  std::string engine = kAutomaticEngine;
  std::uint32_t reorder = 0;  ///< engine forward: points of an octree cell that is not divided; 0: automatic

  bool operator==(const IndexInputs&) const = default;
};

/// What to make beside the engines that renders look up.
struct MoreOfMap {
  bool narrow = false;  ///< IndexedMap::narrow()
  bool sample = false;  ///< IndexedMap::sample()
};

/// What update() works with beside its inputs; nothing of it changes the result.
struct MapWork {
  const Tracer& tracer;
  const LitSides& sides;         ///< as the photons of the global map show them
  SharedWork* shared = nullptr;  ///< processes that divide the work; null: none
  Statistics& statistics;
};

/// A map whose stages update() makes, each if its inputs have changed.
class IndexedMap {
 public:
  /// Engines over the map: one, or one for each group of lights, whose sums are the light of all. Where there are many
  /// groups (GroupedMap::kLeastGroups), one and a map of all groups.
  struct Engines : std::vector<std::unique_ptr<DensityEngine>> {
    std::unique_ptr<const GroupedMap> grouped;

    /// Bytes of the indices over so many photons.
    std::uint64_t bytes(std::size_t photons) const;
  };

  struct Photons {
    PhotonBatch batch;
    std::vector<std::uint32_t> sources;  ///< light source of each photon; with light groups
  };

  /// @param name for SharedWork::divide()
  explicit IndexedMap(const char* name) : name_(name) {}

  /// Frees the map.
  void clear() { *this = IndexedMap(name_); }
  /// Frees the map and takes photons.
  void set_photons(const PhotonInputs& inputs, Photons photons);
  bool has_photons(const PhotonInputs& inputs) const { return photons_.is_made_of(inputs); }
  /// Measures radii, corrects kernels and makes the engines. @param more to make, too
  /// @param widest radii that no photon exceeds; null: none. It must depend on nothing but the inputs
  void update(const IndexInputs& inputs, MoreOfMap more, const MapWork& work, const QueryRadii* widest = nullptr);
  bool is_up_to_date(const IndexInputs& inputs, MoreOfMap more) const;
  /// Frees all but the engines, and what correct() needs.
  void drop_photons();

  /// The last photons that were set, also after drop_photons().
  std::size_t count() const { return count_; }
  /// Empty after drop_photons(), as radii() and flux() are.
  const Photons& photons() const { return *photons_; }
  const PhotonRadii& radii() const { return *radii_; }
  /// Flux with the photons' factors of correction, W.
  LargeVector<RGB> flux() const;
  /// The kernels of the photons.
  RadiusPolicy policy(const KernelInputs& inputs) const;

  const Engines& engines() const { return *engines_; }
  /// What the engines were made of; null: there are none.
  const IndexInputs* inputs() const { return engines_.inputs(); }
  /// Engines with kernels of half the area, and the factor on their radii; empty: not wanted, or no photons.
  const Engines& narrow() const { return *narrow_; }
  static constexpr float kNarrow = 0.70710678f;
  /// At most so many of the photons; empty where that is not wanted.
  const PhotonSample& sample() const { return *sample_; }
  static constexpr std::size_t kMostSampled = 32'768;
  /// Radii of estimates; null without BoundaryCorrection::estimates.
  const QueryRadii* query_radii() const { return query_radii_->get(); }
  /// Memory of what there is, but for the engines().
  std::uint64_t bytes() const;

 private:
  struct Correction {
    std::vector<PhotonCuts> cuts;  ///< of kernels at walls
    std::vector<float> factors;    ///< on the flux; with BoundaryCorrection::photons
  };

  PhotonRadii measure(const RadiusInputs& inputs, const QueryRadii* widest) const;
  Correction correction(const KernelInputs& inputs, const MapWork& work) const;
  std::vector<float> factors(RadiusPolicy policy, const std::string& name, std::vector<PhotonCuts>* cuts,
                             bool on_all_surfaces, const MapWork& work) const;
  Engines index(const IndexInputs& inputs, const LargeVector<RGB>& flux, const RadiusPolicy& policy,
                const MapWork& work) const;
  Engines index_narrow(const IndexInputs& inputs, const MapWork& work) const;
  PhotonSample choose_sample(const KernelInputs& inputs, Statistics& statistics) const;

  const char* name_;
  std::size_t count_ = 0;
  Memo<PhotonInputs, Photons> photons_;
  Memo<RadiusInputs, PhotonRadii> radii_;  // for a radius_scale of 1
  Memo<KernelInputs, Correction> correction_;
  Memo<KernelInputs, std::unique_ptr<QueryRadii>> query_radii_;
  Memo<IndexInputs, Engines> engines_, narrow_;
  Memo<KernelInputs, PhotonSample> sample_;
};

/// Radii times a factor.
std::vector<float> scaled(std::vector<float> radii, float factor);

}  // namespace glowworm
