#include "gather/gather_points.h"

namespace glowworm {

namespace {
template <typename T>
void join(std::vector<T>& a, const std::vector<T>& b) {
  a.insert(a.end(), b.begin(), b.end());
}
}  // namespace

void GatherPoints::append(const GatherPoints& other) {
  join(slot, other.slot);
  join(sequence, other.sequence);
  join(sample, other.sample);
  join(position, other.position);
  join(normal, other.normal);
  join(frame, other.frame);
  join(wo, other.wo);
  join(bsdf, other.bsdf);
  join(throughput, other.throughput);
}

void SlotRadiance::resize(std::size_t slots) {
  emitted.assign(slots, RGB());
  direct.assign(slots, RGB());
  indirect.assign(slots, RGB());
  caustic.assign(slots, RGB());
}

}  // namespace glowworm
