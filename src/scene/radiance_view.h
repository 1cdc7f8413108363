// Views as Radiance writes them, in view files and in the VIEW= lines of its pictures.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "scene/camera.h"
#include "scene/scene.h"

namespace glowworm {

/// A view by the options of Radiance's programs (rpict(1)): -vtv, -vtl, -vth and -vta; -vp, -vd, -vu, -vh, -vv.
struct RadianceView {
  CameraKind kind = CameraKind::perspective;
  Vec3d position{0, 0, 0}, direction{0, 1, 0}, up{0, 0, 1};  ///< metres, in the axes of the user's file
  double horizontal = 45, vertical = 45;                     ///< degrees; orthographic: metres
};

/// Reads the options that a RadianceView has, and skips others, such as the name of a program. Throws Error for a
/// direction without length, for one that is not finite, for sizes and types of views that no camera has, and for -vs
/// and -vl other than 0.
RadianceView parse_radiance_view(std::string_view text);

/// The views of a file: a line of options each, as rvu(1) writes them; other lines are skipped. Throws Error with file
/// and line as parse_radiance_view() does, and for a file without views.
std::vector<RadianceView> parse_radiance_views(std::string_view text, const std::string& path);

/// "-vta -vp x y z -vd x y z -vu x y z -vh degrees -vv degrees".
std::string radiance_view_text(const RadianceView& view);

/// The view of a camera of the scene; "" for a panorama, for which Radiance has no type.
std::string radiance_view_text(const Camera& camera, const Scene& scene, int width, int height);

/// The camera of a view, and the shape of its picture. In others it shows the angle of the view's shorter side.
Camera camera_of(const RadianceView& view, const Scene& scene);
/// The same in a scene whose file has z up or not (SceneDescription::z_up), and whose positions are relative to
/// `origin`.
Camera camera_of(const RadianceView& view, bool z_up, Vec3 origin);

}  // namespace glowworm
