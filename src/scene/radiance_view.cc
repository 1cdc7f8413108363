#include "scene/radiance_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/lines.h"

namespace glowworm {

namespace {

constexpr double kDegree = M_PI / 180;

/// The letters of -vt.
constexpr std::array<std::pair<char, CameraKind>, 4> kTypes = {{{'v', CameraKind::perspective},
                                                                {'l', CameraKind::orthographic},
                                                                {'h', CameraKind::hemispherical},
                                                                {'a', CameraKind::fisheye}}};

/// Reads the numbers behind words[at].
template <std::size_t kCount>
std::array<double, kCount> numbers_after(const std::vector<std::string_view>& words, std::size_t at) {
  std::array<double, kCount> out{};
  for (std::size_t i = 0; i < kCount; ++i) {
    std::string_view rest = at + 1 + i < words.size() ? words[at + 1 + i] : std::string_view();
    if (!take_number(rest, out[i]) || !rest.empty() || !std::isfinite(out[i]))
      throw Error(fmt::format("option {} of the view needs {} numbers", words[at], kCount),
                  "Write a view as -vta -vp 1 2 1.2 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180.");
  }
  return out;
}

/// The most that -vh and -vv may be: below 180 degrees for perspective views; any length in metres.
double most_of(CameraKind kind) {
  if (kind == CameraKind::orthographic) return std::numeric_limits<float>::max();
  return kind == CameraKind::fisheye ? 360 : kind == CameraKind::hemispherical ? 180 : 179.9;
}

/// The camera's plane along one side, from the middle, as degrees or metres.
double angle_of(CameraKind kind, double half) {
  if (kind == CameraKind::orthographic) return 2 * half;
  if (kind == CameraKind::fisheye) return 2 * half / kDegree;
  return 2 / kDegree * (kind == CameraKind::perspective ? std::atan(half) : std::asin(std::min(half, 1.0)));
}

}  // namespace

RadianceView parse_radiance_view(std::string_view text) {
  RadianceView view;
  const std::vector<std::string_view> words = words_of(text);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string_view word = words[i];
    if (word.starts_with("-vt") && word.size() == 4) {
      const auto* const type =
          std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& known) { return known.first == word[3]; });
      if (type == kTypes.end())
        throw Error(fmt::format("views of the type {} are not supported", word), "Give -vta, -vth, -vtv or -vtl.");
      view.kind = type->second;
    }
    for (const auto& [name, vector] :
         {std::pair("-vp", &view.position), std::pair("-vd", &view.direction), std::pair("-vu", &view.up)})
      if (word == name) {
        const auto [x, y, z] = numbers_after<3>(words, i);
        *vector = {x, y, z};
      }
    if (word == "-vh") view.horizontal = numbers_after<1>(words, i)[0];
    if (word == "-vv") view.vertical = numbers_after<1>(words, i)[0];
    if ((word == "-vs" || word == "-vl") && numbers_after<1>(words, i)[0] != 0)
      throw Error(fmt::format("views with {} are not supported", word), "Cut the picture by --crop instead.");
  }
  for (const auto& [name, size] : {std::pair("-vh", view.horizontal), std::pair("-vv", view.vertical)})
    if (!(size > 0 && size <= most_of(view.kind)))
      throw Error(fmt::format("{} {:g} is no size of such a view", name, size),
                  "Give degrees: below 180 for -vtv, up to 180 for -vth and up to 360 for -vta; or metres for -vtl.");
  if (!(length(cross(narrow(view.direction), narrow(view.up))) > 0))
    throw Error("the view has no direction, or looks along -vu", "Give -vd and -vu along different lines.");
  return view;
}

std::vector<RadianceView> parse_radiance_views(std::string_view text, const std::string& path) {
  std::vector<RadianceView> views;
  for (int line = 1; !text.empty(); ++line) {
    const std::string_view words = take_line(text);
    if (words.find("-v") == std::string_view::npos || words.starts_with('#')) continue;
    try {
      views.push_back(parse_radiance_view(words));
    } catch (const Error& error) {
      throw Error(FilePlace{path, line}, error.what());
    }
  }
  if (views.empty())
    throw Error(FilePlace{path}, "the file holds no view", "Write a line such as -vp 1 2 1.2 -vd 0 1 0.");
  return views;
}

std::string radiance_view_text(const RadianceView& v) {
  const auto* const type =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& known) { return known.second == v.kind; });
  // Six digits, and those of millimetres in places far from the origin.
  const auto number = [](double x) {
    return fmt::format("{:.{}g}", x, 6 + std::max(static_cast<int>(std::log10(std::max(std::abs(x), 1.0))) - 2, 0));
  };
  const auto vector = [&](const Vec3d& p) { return fmt::format("{} {} {}", number(p.x), number(p.y), number(p.z)); };
  return fmt::format("-vt{} -vp {} -vd {} -vu {} -vh {:g} -vv {:g}", type->first, vector(v.position),
                     vector(v.direction), vector(v.up), v.horizontal, v.vertical);
}

std::string radiance_view_text(const Camera& camera, const Scene& scene, int width, int height) {
  if (camera.kind == CameraKind::panorama) return "";
  const Transform& m = camera.to_world;
  const ScreenWindow window = screen_window(camera, width, height);
  // + 0 writes 0 in place of -0
  const auto direction = [&](Vec3 d) { return Vec3d(scene.to_file_axes(normalize(d)) + Vec3{0, 0, 0}); };
  RadianceView view;
  view.kind = camera.kind;
  view.position = scene.to_file_axes(scene.outside(m.translation));
  view.direction = direction(m.z);
  view.up = direction(m.y);
  view.horizontal = angle_of(camera.kind, std::abs(double{window.right} - window.left) / 2);
  view.vertical = angle_of(camera.kind, std::abs(double{window.top} - window.bottom) / 2);
  return radiance_view_text(view);
}

Camera camera_of(const RadianceView& view, const Scene& scene) { return camera_of(view, scene.z_up(), scene.origin()); }

Camera camera_of(const RadianceView& view, bool z_up, Vec3 origin) {
  const auto axes = [&](const Vec3d& v) { return z_up ? y_up_from_z_up(v) : v; };
  const auto direction = [&](const Vec3d& d) { return narrow(axes(d)); };
  const Vec3 eye = narrow(axes(view.position) - Vec3d(origin));
  Camera camera = look_at({0, 0, 0}, direction(view.direction), direction(view.up), 45);
  camera.to_world.translation = eye;
  camera.kind = view.kind;
  const auto half = [&](double size) {
    return view.kind == CameraKind::orthographic ? static_cast<float>(size / 2)
                                                 : half_extent_of(view.kind, static_cast<float>(size));
  };
  const float wide = half(view.horizontal), high = half(view.vertical);
  camera.half_extent = std::min(wide, high);
  camera.aspect = wide / high;
  return camera;
}

}  // namespace glowworm
