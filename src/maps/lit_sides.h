// Which side of a surface is its outside.
#pragma once
#include <cstdint>
#include <vector>

#include "points/photon_batch.h"
#include "trace/tracer.h"

namespace glowworm {

/// The side of a triangle that light reaches. The back of a solid is dark; of a single sheet, any side or both are lit.
enum class LitSide : std::uint8_t { front, back, both };

/// The lit sides of triangles, as photons show them, so that the winding does not matter. Where they are too few, those
/// of the triangle's object show it, and the winding where these are too few, too.
class LitSides {
 public:
  /// All fronts, by the winding.
  LitSides() = default;
  /// Uses all threads; deterministic.
  LitSides(const Tracer& tracer, const PhotonBatch& photons);

  LitSide of(const Geometry& geometry, std::uint32_t triangle) const;
  std::uint64_t bytes() const { return triangles_.capacity() * sizeof(Lit) + objects_.capacity() * sizeof(LitSide); }

 private:
  struct Lit {
    std::uint32_t triangle;
    LitSide side;
  };

  std::vector<Lit> triangles_;    ///< with enough photons, in order
  std::vector<LitSide> objects_;  ///< by number; the front for those with too few
};

}  // namespace glowworm
