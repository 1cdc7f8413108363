// The photon pass: traces light paths from the lights and stores photons on surfaces.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/box.h"
#include "core/shared_work.h"
#include "core/statistics.h"
#include "photon/emission_guide.h"
#include "photon/importance.h"
#include "points/disc_tree.h"
#include "points/photon_batch.h"
#include "points/photon_segment.h"
#include "points/volume_photons.h"
#include "trace/tracer.h"
#include "transport/roulette.h"

namespace glowworm {

class KeptPaths;
class LightImages;

/// The places where the image needs photons.
struct PhotonImportance {
  ImportanceGrid gathered;  ///< of the global map
  ImportanceGrid seen;      ///< of the caustic map, which is looked up at the ends of camera paths
  Box3 box;                 ///< around the scene, its cameras and the points that they see
};

/// The photons that a pass keeps. Paths end when they can no longer leave one.
enum class PhotonChoice : std::uint8_t {
  all,
  caustic,  ///< of PhotonPass::caustic alone
  /// Of these, those of lights without size: no ray from a point meets such a light, and shadow rays end at the surface
  /// that bends its light.
  caustic_of_deltas,
  /// Of these, those whose first bounce was perfectly smooth: after a rough one, the path tracer finds the light by its
  /// shadow rays.
  unseen_by_paths,
};

/// Settings of a photon pass.
struct PhotonPassSettings {
  std::uint64_t photons = 500'000;  ///< photons wanted in the global map; paths are emitted until it has this many
  std::uint64_t max_emitted = 0;    ///< most paths, even if few photons were stored; 0: 200 times `photons`
  std::uint32_t seed = 0;
  std::uint32_t pass = 0;  ///< passes of one seed have different photons
  int max_bounces = kNoBounceLimit;
  const EmissionGuide* guide = nullptr;          ///< null: emission in proportion to power
  const PhotonImportance* importance = nullptr;  ///< decides which photons count as used; null: all
  /// Also store photons on black, specular and transparent surfaces, for irradiance, which needs no material. Pictures
  /// look up none there.
  bool on_all_surfaces = false;
  bool keep_sources = false;  ///< fill PhotonPass::global_source and caustic_source
  /// All but PhotonChoice::all: make only PhotonPass::caustic, of `photons` photons.
  PhotonChoice choice = PhotonChoice::all;
  /// Fill PhotonPass::segments with the parts of paths that cross one of these discs; null: none. With other choices
  /// than all, the pass makes them in place of PhotonPass::caustic, and leaves out those that come from `images`.
  const DiscTree* discs = nullptr;
  const LightImages* images = nullptr;  ///< null: none
  SharedWork* shared = nullptr;         ///< processes that divide the pass; null: this one traces all of it
  /// Paths of the pass at another moment, after KeptPaths::begin(); then those of this pass. The pass has no flux
  /// balance. null: none are kept.
  KeptPaths* kept = nullptr;
};

/// Flux of a pass, in W. Emitted flux is counted by its fate: emitted + scattered = arrived + escaped + cut, and
/// absorbed = arrived - scattered. Does not hold with choices of photons, where paths end early.
struct FluxBalance {
  std::array<double, 3> emitted{}, arrived{}, scattered{}, escaped{}, cut{};
  std::array<double, 3> stored{};  ///< flux of the photons of the global map, before correction by shading normals
};

/// Photons of one pass. Flux is already divided by the number of emitted paths.
struct PhotonPass {
  PhotonBatch global;   ///< photons at every surface with a broad lobe, after any path
  PhotonBatch caustic;  ///< those with at least one bounce and only specular ones; a passage of a pane does not count
  std::vector<PhotonSegment> segments;  ///< by PhotonPassSettings::discs
  /// Photons in media: those of media's own light, and others after one bounce or more. Light samples bring light
  /// straight from lamps. With PhotonChoice::unseen_by_paths only light that the path tracer's paths do not find.
  VolumePhotons in_media;
  VolumeBeams beams;  ///< the same photons, on their way
  /// Light source of each photon, counted as in Scene::light_power(); empty unless they are kept.
  std::vector<std::uint32_t> global_source, caustic_source;
  std::uint64_t emitted = 0,
                stored = 0;  ///< paths, and photons of the map or segments that the pass makes
  FluxBalance balance;
  /// By light source, in the order of Scene::light_power(). `used`: stored photons at places that the image needs.
  std::vector<std::uint64_t> emitted_by_light, stored_by_light, used_by_light;
};

/// Traces photons until the global map has the wanted number, on all threads; the result does not depend on their
/// number. Adds to Phase::trace_photons and counts photons_emitted, photons_stored and photons_kept.
PhotonPass trace_photons(const Tracer& tracer, const PhotonPassSettings& settings, Statistics& statistics);

/// Traces `count` paths of a pilot pass, from path `first` on, with settings.guide; fewer, in whole chunks, if they
/// store `photons_left` photons before, as paths do that bounce on and on in a closed white room. Takes what they store
/// off `photons_left`. A path's score is its contribution to settings.importance (everywhere 1 if null) in units of one
/// photon's share of all power, without the guide's factor. With settings.discs, the contribution is that of its
/// segments; paths of choice `all` have both. PilotPath::density is that of the guide only. The result does not depend
/// on the number of threads.
std::vector<PilotPath> trace_pilot(const Tracer& tracer, const PhotonPassSettings& settings, std::uint64_t first,
                                   std::size_t count, std::uint64_t& photons_left);

}  // namespace glowworm
