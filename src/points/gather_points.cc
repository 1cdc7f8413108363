#include "points/gather_points.h"

namespace glowworm {

void GatherPoints::reserve(std::size_t n) {
  for_arrays([n](auto& array) { array.reserve(n); }, *this);
}

void GatherPoints::clear() {
  for_arrays([](auto& array) { array.clear(); }, *this);
}

void GatherPoints::append(const GatherPoints& other) {
  for_arrays([](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); }, *this, other);
}

void SlotRadiance::resize(std::size_t slots, bool media) {
  emitted.assign(slots, RGB());
  direct.assign(slots, RGB());
  indirect.assign(slots, RGB());
  caustic.assign(slots, RGB());
  medium.assign(media ? slots : 0, RGB());
  for (auto& group : groups) group.assign(slots, RGB());
}

}  // namespace glowworm
