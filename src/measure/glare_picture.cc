#include "measure/glare_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include "core/error.h"
#include "measure/measurement.h"

namespace glowworm {

namespace {

/// Key of the luminance of white in EXR files.
constexpr const char* kWhiteLuminance = "whiteLuminance";
constexpr const char* kViewRemedy = "Give --view \"-vta -vp 0 0 1.2 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180\".";

/// A saturated colour of luminance 1 for each source. Neighbouring numbers have hues that differ much: steps of the
/// golden section around the circle.
RGB color_of_source(std::size_t index) {
  constexpr double kStep = 0.61803398875;
  const double hue = 6 * std::fmod(static_cast<double>(index) * kStep, 1.0);
  const auto channel = [&](double middle) {
    const double apart = std::abs(std::remainder(hue - middle, 6.0));
    return static_cast<float>(std::clamp(2 - apart, 0.0, 1.0));
  };
  const RGB color{channel(0), channel(2), channel(4)};
  return color * (1 / luminance(color));
}

/// Draws a ring of this radius, in pixels, of two pixels' width.
void draw_ring(std::vector<RGB>& pixels, int width, int height, Vec2 middle, float radius, RGB color) {
  const int reach = static_cast<int>(radius) + 2;
  for (int y = static_cast<int>(middle.y) - reach; y <= static_cast<int>(middle.y) + reach; ++y)
    for (int x = static_cast<int>(middle.x) - reach; x <= static_cast<int>(middle.x) + reach; ++x) {
      const float apart = std::hypot(static_cast<float>(x) + 0.5f - middle.x, static_cast<float>(y) + 0.5f - middle.y);
      if (x < 0 || y < 0 || x >= width || y >= height || std::abs(apart - radius) > 1) continue;
      pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = color;
    }
}

}  // namespace

RadianceView view_of_picture(const Image& image, const std::string& path, const std::string& given) {
  if (!given.empty()) return parse_radiance_view(given);
  const auto view = image.metadata.find(kRadianceView);
  if (view == image.metadata.end()) throw Error(FilePlace{path}, "the picture has no view in its header", kViewRemedy);
  return parse_radiance_view(view->second);
}

GlarePicture glare_picture_of(const Image& image, const RadianceView& view) {
  if (view.kind != CameraKind::fisheye && view.kind != CameraKind::hemispherical)
    throw Error("glare is rated in fisheye pictures, and the view is none",
                "Render it with -vta (equidistant) or -vth (hemispherical), with -vh 180 -vv 180.");
  for (const double angle : {view.horizontal, view.vertical})
    if (!(angle >= 1 && angle <= 360))
      throw Error(fmt::format("the view of the picture has an angle of {:g} degrees", angle), kViewRemedy);
  GlarePicture out;
  out.kind = view.kind;
  out.width = image.width();
  out.height = image.height();
  out.half_x = half_extent_of(view.kind, static_cast<float>(view.horizontal));
  out.half_y = half_extent_of(view.kind, static_cast<float>(view.vertical));
  const auto white = image.metadata.find(kWhiteLuminance);
  const float scale = white == image.metadata.end() ? 0 : std::strtof(white->second.c_str(), nullptr);
  const float efficacy = scale > 0 ? scale : kLuminousEfficacy;
  out.luminance.reserve(image.pixel_count());
  for (const RGB& pixel : image.rgb()) {
    out.luminance.push_back(efficacy * luminance(pixel));
    if (!std::isfinite(out.luminance.back()))
      throw Error("the picture has pixels that are not finite", "Glare needs the luminance of every pixel.");
  }
  return out;
}

Image glare_image(const GlarePicture& picture, const Glare& glare, bool rings) {
  std::vector<RGB> pixels;
  pixels.reserve(picture.luminance.size());
  for (std::size_t i = 0; i < picture.luminance.size(); ++i) {
    const std::uint32_t source = glare.source_of[i];
    const RGB hue = source == kNoGlareSource ? RGB(1.0f) : color_of_source(source);
    pixels.push_back(hue * (picture.luminance[i] / kLuminousEfficacy));
  }
  const float across = static_cast<float>(picture.width) / (2 * picture.half_x);
  const float down = static_cast<float>(picture.height) / (2 * picture.half_y);
  for (std::size_t i = 0; rings && i < glare.sources.size(); ++i) {
    constexpr float kGap = 4;  // pixels between a source and its ring
    const GlareSource& source = glare.sources[i];
    const Vec2 plane = angular_plane(picture.kind, source.direction);
    const Vec2 middle{(plane.x + picture.half_x) * across, (picture.half_y - plane.y) * down};
    const float radius = std::sqrt(static_cast<float>(source.solid_angle) / kPi) * std::min(across, down) + kGap;
    draw_ring(pixels, picture.width, picture.height, middle, radius,
              color_of_source(i) * (static_cast<float>(source.luminance) / kLuminousEfficacy));
  }
  Image out(picture.width, picture.height);
  out.add_rgb("", pixels);
  out.radiance_scale = 1;
  return out;
}

}  // namespace glowworm
