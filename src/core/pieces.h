// Pieces of parallel loops.
#pragma once
#include <algorithm>
#include <cstddef>

namespace glowworm {

/// Items in a piece of a parallel loop (core/parallel.h) whose items take a microsecond or more: it has 256 pieces, or
/// one for each item, so that threads end together. Depends on the number of items alone.
inline constexpr std::size_t even_grain(std::size_t count) { return std::max<std::size_t>((count + 255) / 256, 1); }

}  // namespace glowworm
