// A picture of a view with the surfaces in it.
#pragma once
#include <cstddef>
#include <vector>

#include "core/rgb.h"
#include "core/vec.h"
#include "scene/camera.h"

namespace glowworm {

/// Arrays of width * height entries, row by row from the top.
struct ViewImage {
  Camera camera;
  int width = 0, height = 0;
  std::vector<RGB> light;      ///< radiance, W sr^-1 m^-2 (or the quantity of another mode)
  std::vector<RGB> albedo;     ///< of the first surface
  std::vector<Vec3> normal;    ///< unit, or (0, 0, 0) for nothing
  std::vector<float> depth;    ///< metres along the ray to the first surface; infinity for none
  std::vector<Vec3> position;  ///< of the first surface, metres; if there is none, far along the ray

  std::size_t size() const { return light.size(); }
  bool empty() const { return light.empty(); }
  /// Sets positions from camera and depth, for rays through the middle of pixels.
  void find_positions();
};

}  // namespace glowworm
