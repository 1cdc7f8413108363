// Cameras.
#pragma once
#include <cstdint>
#include <string>

#include "core/transform.h"
#include "core/vec.h"

namespace glowworm {

enum class CameraKind : std::uint8_t { perspective, orthographic };

/// A camera. In its own space it looks along +z, with +x to the right of the picture and +y up; to_world may mirror
/// (pbrt). The picture plane is the screen window at z = 1 (perspective). Its unit makes half of the picture's shorter
/// side equal to `half_extent`.
struct Camera {
  std::string name;
  CameraKind kind = CameraKind::perspective;
  Transform to_world;
  /// perspective: tan of half the field of view along the shorter side; orthographic: half the shorter side, metres.
  float half_extent = 0.5f;
  /// Screen window in units of half_extent (left, right, bottom, top); all zero: derived from the picture's shape, with
  /// 1 along the shorter side.
  float window[4] = {0, 0, 0, 0};
  float lens_radius = 0;     ///< metres; 0 is a pinhole
  float focal_distance = 1;  ///< metres along the axis
};

/// The sides of the picture plane at z = 1, in units of the camera's space.
struct ScreenWindow {
  float left, right, bottom, top;
};
ScreenWindow screen_window(const Camera& camera, int width, int height);

struct CameraRay {
  Vec3 origin;
  Vec3 direction;  ///< unit
};

/// The ray through a point of the picture.
/// @param film in pixels, from the upper left corner; @param width, height of the picture in pixels
/// @param lens a point of the unit square
CameraRay generate_ray(const Camera& camera, Vec2 film, int width, int height, Vec2 lens);

/// A camera at `eye` looking at `target`, with a field of view in degrees along the shorter side.
Camera look_at(Vec3 eye, Vec3 target, Vec3 up, float field_of_view_degrees);

}  // namespace glowworm
