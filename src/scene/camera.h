// Cameras.
#pragma once
#include <cstdint>
#include <string>

#include "core/transform.h"
#include "core/vec.h"

namespace glowworm {

enum class CameraKind : std::uint8_t {
  perspective,
  orthographic,
  fisheye,        ///< equidistant: the distance from the middle of the picture is the angle from the axis, up to 180
  hemispherical,  ///< orthographic fisheye: that distance is the sine of the angle, up to 90 degrees
  panorama,       ///< equirectangular: x is the longitude from the axis, y the latitude
};

/// Whether the picture plane of a camera holds angles, not lengths at z = 1.
inline bool is_angular(CameraKind kind) { return kind > CameraKind::orthographic; }

/// A camera. In its own space it looks along +z, with +x to the right of the picture and +y up; to_world may mirror
/// (pbrt). The picture plane is the screen window at z = 1 (perspective). Its unit makes half of the picture's shorter
/// side equal to `half_extent`.
struct Camera {
  std::string name;
  CameraKind kind = CameraKind::perspective;
  Transform to_world;
  /// perspective: tan of half the field of view along the shorter side; orthographic: half the shorter side, metres;
  /// hemispherical: sin of half the field of view; fisheye and panorama: half the field of view, radians.
  float half_extent = 0.5f;
  /// Screen window in units of half_extent (left, right, bottom, top); all zero: derived from the picture's shape, with
  /// 1 along the shorter side.
  float window[4] = {0, 0, 0, 0};
  float aspect = 0;          ///< width over height of the picture that it is made for; 0: any
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
  Vec3 direction;  ///< unit; 0: the camera shows nothing there, and the picture is black

  bool is_blind() const { return direction.x == 0 && direction.y == 0 && direction.z == 0; }
};

/// The ray through a point of the picture.
/// @param film in pixels, from the upper left corner; @param width, height of the picture in pixels
/// @param lens a point of the unit square
CameraRay generate_ray(const Camera& camera, Vec2 film, int width, int height, Vec2 lens);

/// The direction that a point of the picture plane shows, unit in the camera's space; 0 beyond the camera's view.
/// @param plane in the units of half_extent; @param kind is_angular()
Vec3 angular_direction(CameraKind kind, Vec2 plane);
/// Its inverse, for a direction that the camera sees.
Vec2 angular_plane(CameraKind kind, Vec3 direction);
/// The solid angle that an area of the picture plane shows, over that area; 0 beyond the camera's view.
double solid_angle_density(CameraKind kind, Vec2 plane);

/// Camera::half_extent of a field of view along the shorter side. @param kind not orthographic
float half_extent_of(CameraKind kind, float field_of_view_degrees);

/// Whether all rays of two cameras are the same.
bool same_view(const Camera& a, const Camera& b);

/// A camera at `eye` looking at `target`, with a field of view in degrees along the shorter side.
Camera look_at(Vec3 eye, Vec3 target, Vec3 up, float field_of_view_degrees);

}  // namespace glowworm
