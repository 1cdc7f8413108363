#include "control/path_history.h"

namespace glowworm {

PathHistory PathHistory::with_medium() const {
  PathHistory out = *this;
  (gathered ? out.broad_after_gather : out.in_medium) = true;
  return out;
}

PathHistory PathHistory::with_bounce(Lobes lobe, bool delta) const {
  PathHistory out = *this;
  if (lobe != kSpecular)
    (gathered ? out.broad_after_gather : out.gathered) = true;
  else if (gathered)
    out.specular_after_gather = true;
  else if (!delta)
    out.rough_specular = true;
  return out;
}

std::vector<RGB>& PathHistory::part(SlotRadiance& radiance) const {
  if (in_medium) return radiance.medium;
  if (!gathered) return rough_specular ? radiance.direct : radiance.emitted;
  if (broad_after_gather) return radiance.indirect;
  return specular_after_gather ? radiance.caustic : radiance.direct;
}

void PathLookups::clear() {
  caustic.clear();
  indirect.clear();
  air.clear();
  in_media.clear();
  indirect_in_media.clear();
}

void PathLookups::append(const PathLookups& other) {
  caustic.append(other.caustic);
  indirect.append(other.indirect);
  air.insert(air.end(), other.air.begin(), other.air.end());
  in_media.append(other.in_media);
  indirect_in_media.append(other.indirect_in_media);
}

}  // namespace glowworm
