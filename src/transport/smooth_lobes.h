// Perfectly smooth lobes, which paths can follow one by one.
#pragma once
#include <array>
#include <cstddef>

#include "transport/vertex.h"

namespace glowworm {

/// The sharp lobes of a vertex if all of them are perfectly smooth, with what each of them passes on; none otherwise.
struct SmoothLobes {
  std::array<ScatteredRay, 2> ray;
  std::size_t count = 0;
};
SmoothLobes smooth_lobes(const Vertex& vertex);

}  // namespace glowworm
