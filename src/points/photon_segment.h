// A straight part of a photon's path, for points in air, where no photon ends.
#pragma once
#include <cstdint>

#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm {

struct PhotonSegment {
  Vec3 origin;              ///< metres
  float length = 0;         ///< metres; may be infinite
  Vec3 direction;           ///< unit, from the origin on
  std::uint32_t light = 0;  ///< source, counted as in Scene::light_power()
  RGB flux;                 ///< W, at the origin
  RGB absorption;           ///< m^-1, of a medium around it that does not scatter; else the photon ends by chance
};

}  // namespace glowworm
