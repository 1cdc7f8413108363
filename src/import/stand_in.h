// What takes the place of a texture that is missing.
#pragma once
#include <cstdint>

namespace glowworm {

/// What takes the place of a texture that cannot be read: magenta where it is the colour of a surface, so that it
/// shows, and what changes nothing where it is data.
enum class StandIn : std::uint8_t {
  magenta,
  one,           ///< the factor alone counts
  none,          ///< no emission
  flat_normal,   ///< of a normal map
  along_tangent  ///< KHR_materials_anisotropy: no rotation, and the strength alone
};

}  // namespace glowworm
