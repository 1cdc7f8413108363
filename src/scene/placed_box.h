// Boxes of instances.
#pragma once
#include "core/box.h"
#include "core/transform.h"

namespace glowworm {

/// The box around a transformed box.
inline Box3 placed_box(const Transform& to_world, const Box3& mesh) {
  Box3 box;
  for (int corner = 0; corner < 8; ++corner)
    box.grow(to_world.point({corner & 1 ? mesh.max.x : mesh.min.x, corner & 2 ? mesh.max.y : mesh.min.y,
                             corner & 4 ? mesh.max.z : mesh.min.z}));
  return box;
}

}  // namespace glowworm
