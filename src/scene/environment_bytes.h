// Memory of environments.
#pragma once
#include <cstdint>

namespace glowworm {

/// Bytes of the image of an environment of so many texels in a scene, with its distribution while that is made.
std::uint64_t environment_bytes(std::uint64_t texels);

}  // namespace glowworm
