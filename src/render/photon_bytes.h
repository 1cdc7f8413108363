// Memory of photons.
#pragma once
#include <cstdint>

namespace glowworm {

/// Bytes of a render by so many photons while it looks for bright patches, besides its photons.
std::uint64_t bright_patch_bytes(std::uint64_t photons);

}  // namespace glowworm
