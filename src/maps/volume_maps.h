// Maps of photons in media, as stages of PhotonMaps.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/rgb.h"
#include "core/statistics.h"
#include "density/volume_map.h"
#include "maps/indexed_map.h"
#include "trace/tracer.h"

namespace glowworm {

/// Photons in media, as points and as beams.
struct MediaPhotons {
  VolumePhotons points;
  VolumeBeams beams;
};

/// Indices of photons in media, one for all light sources or one for each group of them. Each medium has either points
/// or beams: beams where its optical thickness across half of its size is below 1/32, unless colours fall off unequally
/// in a grid, which beams cannot show; else points.
class VolumeMaps {
 public:
  /// Adds what the photons of a group bring to segments, as VolumeMap::estimate().
  void estimate(std::size_t group, const VolumeSegments& segments, std::span<RGB> found, Statistics& statistics) const;
  std::size_t group_count() const { return groups_.size(); }
  std::uint64_t bytes() const { return bytes_; }

 private:
  friend class VolumeMapsBuilder;
  struct Group {
    VolumeMap points, beams;
  };
  std::vector<Group> groups_;
  std::uint64_t bytes_ = 0;
};

/// The maps of a scene's media.
struct MediaMaps {
  VolumeMaps all;
  /// A few of the photons with random signs, in one group: the square of a sum has the expectation of its variance by
  /// all photons, as for a bootstrap (Efron, "Bootstrap Methods: Another Look at the Jackknife", 1979) that weighs
  /// photons by 0 or 2.
  VolumeMaps signed_sample;
  bool is_sampled = false;  ///< whether `signed_sample` was wanted
};

/// Adds the light that photons in media bring to segments to their targets, and that of each group to `groups`.
/// @param groups empty, or as many as the maps have @param found memory of the caller
void add_light_of_media(const VolumeMaps& maps, const VolumeSegments& segments, LargeVector<RGB>& found,
                        std::vector<RGB>& target, std::span<std::vector<RGB>> groups, Statistics& statistics);

/// Measures radii, corrects kernels at boundaries, and makes the indices. Empty in scenes without media.
/// @param sampled whether to make MediaMaps::signed_sample, too (Phase::photon_noise)
MediaMaps make_media_maps(const Tracer& tracer, const MediaPhotons& photons, const IndexInputs& inputs, bool sampled,
                          Statistics& statistics);

}  // namespace glowworm
