#include "points/gather_points.h"

namespace glowworm {

void GatherPoints::reserve(std::size_t n) {
  slot.reserve(n);
  sequence.reserve(n);
  sample.reserve(n);
  position.reserve(n);
  normal.reserve(n);
  offset.reserve(n);
  frame.reserve(n);
  wo.reserve(n);
  bsdf.reserve(n);
  throughput.reserve(n);
}

void GatherPoints::clear() {
  slot.clear();
  sequence.clear();
  sample.clear();
  position.clear();
  normal.clear();
  offset.clear();
  frame.clear();
  wo.clear();
  bsdf.clear();
  throughput.clear();
}

void GatherPoints::append(const GatherPoints& other) {
  slot.insert(slot.end(), other.slot.begin(), other.slot.end());
  sequence.insert(sequence.end(), other.sequence.begin(), other.sequence.end());
  sample.insert(sample.end(), other.sample.begin(), other.sample.end());
  position.insert(position.end(), other.position.begin(), other.position.end());
  normal.insert(normal.end(), other.normal.begin(), other.normal.end());
  offset.insert(offset.end(), other.offset.begin(), other.offset.end());
  frame.insert(frame.end(), other.frame.begin(), other.frame.end());
  wo.insert(wo.end(), other.wo.begin(), other.wo.end());
  bsdf.insert(bsdf.end(), other.bsdf.begin(), other.bsdf.end());
  throughput.insert(throughput.end(), other.throughput.begin(), other.throughput.end());
}

void SlotRadiance::resize(std::size_t slots) {
  emitted.assign(slots, RGB());
  direct.assign(slots, RGB());
  indirect.assign(slots, RGB());
  caustic.assign(slots, RGB());
  for (auto& group : groups) group.assign(slots, RGB());
}

}  // namespace glowworm
