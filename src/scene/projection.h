// Points of the world in a camera's picture.
#pragma once
#include "core/vec.h"
#include "scene/camera.h"

namespace glowworm {

/// A point of the world in the picture.
struct Projection {
  Vec2 film;  ///< pixels from the upper left corner
  float depth =
      0;  ///< metres from the camera's position (perspective) or plane (orthographic) along the ray; <= 0: behind
};
Projection project(const Camera& camera, Vec3 point, int width, int height);

/// Position, as far as a pinhole sees it, at `depth` metres along the ray through a point of the picture.
Vec3 unproject(const Camera& camera, Vec2 film, int width, int height, float depth);

}  // namespace glowworm
