#include "gather/gather_points.h"

#include "core/parallel.h"

namespace glowworm {

namespace {

/// Appends one array of all parts.
template <typename Array>
void join(GatherPoints& points, std::span<const GatherPoints> parts, Array array) {
  auto& to = points.*array;
  std::size_t size = to.size();
  for (const GatherPoints& part : parts) size += part.size();
  to.reserve(size);
  for (const GatherPoints& part : parts) to.insert(to.end(), (part.*array).begin(), (part.*array).end());
}

}  // namespace

void GatherPoints::reserve(std::size_t n) {
  slot.reserve(n);
  sequence.reserve(n);
  sample.reserve(n);
  position.reserve(n);
  normal.reserve(n);
  frame.reserve(n);
  wo.reserve(n);
  bsdf.reserve(n);
  throughput.reserve(n);
}

void GatherPoints::append(std::span<const GatherPoints> parts) {
  // The materials are about half of all bytes.
  parallel_invoke([&] { join(*this, parts, &GatherPoints::bsdf); },
                  [&] {
                    join(*this, parts, &GatherPoints::slot);
                    join(*this, parts, &GatherPoints::sequence);
                    join(*this, parts, &GatherPoints::sample);
                    join(*this, parts, &GatherPoints::position);
                    join(*this, parts, &GatherPoints::normal);
                    join(*this, parts, &GatherPoints::frame);
                    join(*this, parts, &GatherPoints::wo);
                    join(*this, parts, &GatherPoints::throughput);
                  });
}

void SlotRadiance::resize(std::size_t slots) {
  emitted.assign(slots, RGB());
  direct.assign(slots, RGB());
  indirect.assign(slots, RGB());
  caustic.assign(slots, RGB());
}

}  // namespace glowworm
