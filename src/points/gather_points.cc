#include "points/gather_points.h"

namespace glowworm {

void SlotRadiance::resize(std::size_t slots, bool media) {
  emitted.assign(slots, RGB());
  direct.assign(slots, RGB());
  indirect.assign(slots, RGB());
  caustic.assign(slots, RGB());
  surface_emitted.clear();
  sun.clear();
  medium.assign(media ? slots : 0, RGB());
  for (auto& group : groups) group.assign(slots, RGB());
}

}  // namespace glowworm
