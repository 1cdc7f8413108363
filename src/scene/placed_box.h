// Boxes under transforms.
#pragma once
#include "core/box.h"
#include "core/transform.h"

namespace glowworm {

/// The box around a transformed box.
inline Box3 placed_box(const Transform& map, const Box3& given) {
  Box3 box;
  for (int corner = 0; corner < 8; ++corner)
    box.grow(map.point({corner & 1 ? given.max.x : given.min.x, corner & 2 ? given.max.y : given.min.y,
                        corner & 4 ? given.max.z : given.min.z}));
  return box;
}

}  // namespace glowworm
