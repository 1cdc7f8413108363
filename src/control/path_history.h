// State of the path tracer's paths beside PathState: the layer of their light, and places where photons bring more.
#pragma once
#include <vector>

#include "bsdf/bsdf.h"
#include "maps/air_light.h"
#include "points/gather_points.h"
#include "points/query_points.h"
#include "points/volume_segments.h"

namespace glowworm {

/// Bounces of a path so far, as far as they decide the layer of its light.
struct PathHistory {
  bool gathered = false;        ///< a broad bounce: the path has passed the gather point
  bool rough_specular = false;  ///< a specular bounce that is not a delta, before the gather point
  bool specular_after_gather = false;
  bool broad_after_gather = false;
  bool in_medium = false;  ///< before the gather point

  /// After a medium has scattered or emitted the path's light.
  PathHistory with_medium() const;
  /// After a bounce. @param delta whether its lobe is perfectly smooth
  PathHistory with_bounce(Lobes lobe, bool delta) const;
  /// The layer of light that the path finds.
  std::vector<RGB>& part(SlotRadiance& radiance) const;
};

/// Places of paths where photons bring light that the paths do not find.
struct PathLookups {
  QueryPoints caustic, indirect;  ///< by the layer of their light; gather_point is the slot
  std::vector<AirPoint> air;
  VolumeSegments in_media, indirect_in_media;  ///< by the layer; target is the slot

  void clear();
  void append(const PathLookups& other);
};

}  // namespace glowworm
