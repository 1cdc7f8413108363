#include "import/pbrt/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace glowworm {

namespace {

/// The angle of view along the shorter side, in degrees.
float field_of_view(const PbrtParameters& parameters) {
  float degrees = parameters.real("fov", 90);
  // pbrt-v3: half the angle of view along the picture's height.
  if (parameters.has("halffov")) degrees = 2 * parameters.real("halffov", 45);
  if (degrees > 0 && degrees < 180) return degrees;
  parameters.error(fmt::format("a field of view of {} degrees", degrees), "Give \"float fov\" between 0 and 180.");
  return 90;
}

void set_window(Camera& camera, const PbrtParameters& parameters) {
  const auto window = parameters.numbers("screenwindow", PbrtType::real);
  if (window.empty()) return;
  if (window.size() != 4 || window[0] == window[1] || window[2] == window[3]) {
    parameters.error("screenwindow is not a rectangle", "Give four numbers: left, right, bottom and top.");
    return;
  }
  for (int i = 0; i < 4; ++i) camera.window[i] = static_cast<float>(window[i]);
}

/// Sets the crop from "pixelbounds". A cropwindow takes precedence, as in pbrt.
void set_pixel_bounds(FilmRequest& film, const PbrtParameters& parameters) {
  const auto bounds = parameters.numbers("pixelbounds", PbrtType::integer);
  if (bounds.empty() || film.width == 0) return;
  const double size[2] = {static_cast<double>(film.width), static_cast<double>(film.height)};
  if (bounds.size() != 4 || bounds[0] >= bounds[1] || bounds[2] >= bounds[3] || bounds[0] >= size[0] ||
      bounds[2] >= size[1] || bounds[1] <= 0 || bounds[3] <= 0) {
    parameters.error("pixelbounds is not a part of the picture",
                     "Give x0 x1 y0 y1 in pixels with x0 < x1 and y0 < y1.");
    return;
  }
  for (std::size_t i = 0; i < 4; ++i)
    film.crop[i] = static_cast<float>(std::clamp(bounds[i], 0.0, size[i / 2]) / size[i / 2]);
}

void set_crop(FilmRequest& film, const PbrtParameters& parameters) {
  set_pixel_bounds(film, parameters);
  const auto crop = parameters.numbers("cropwindow", PbrtType::real);
  if (crop.empty()) return;
  if (crop.size() == 4 && crop[0] >= 0 && crop[0] < crop[1] && crop[1] <= 1 && crop[2] >= 0 && crop[2] < crop[3] &&
      crop[3] <= 1) {
    for (int i = 0; i < 4; ++i) film.crop[i] = static_cast<float>(crop[i]);
  } else {
    parameters.error("cropwindow is not a part of the picture",
                     "Give x0 x1 y0 y1 with 0 <= x0 < x1 <= 1, and the same for y.");
  }
}

}  // namespace

void set_frame_aspect(Camera& camera, const PbrtParameters& parameters) {
  if (!parameters.has("frameaspectratio") || parameters.has("screenwindow")) return;
  const float aspect = parameters.real("frameaspectratio", 1);
  if (!(aspect > 0)) {
    parameters.error("frameaspectratio must be positive", "Give width over height.");
    return;
  }
  const float wide = std::max(aspect, 1.0f), high = std::max(1 / aspect, 1.0f);
  camera.window[0] = -wide;
  camera.window[1] = wide;
  camera.window[2] = -high;
  camera.window[3] = high;
}

void place_camera(Camera& camera, const Transform& to_world) {
  camera.to_world = to_world;
  // The middle of a panorama looks along -x, and +z is to the left.
  if (camera.kind == CameraKind::panorama)
    camera.to_world = {-to_world.z, to_world.y, -to_world.x, to_world.translation};
}

Shutter shutter_of(const PbrtParameters& parameters) {
  return {parameters.real("shutteropen", 0), parameters.real("shutterclose", 1)};
}

float exposure_time(const PbrtParameters& parameters) {
  const Shutter shutter = shutter_of(parameters);
  const auto time = static_cast<float>(shutter.close - shutter.open);
  return time > 0 ? time : 1;
}

Camera make_camera(const std::string& kind, const PbrtParameters& parameters, const Transform& to_world) {
  Camera camera;
  camera.name = "camera";
  camera.to_world = to_world;
  if (kind == "orthographic") {
    camera.kind = CameraKind::orthographic;
    camera.half_extent = 1;
  } else if (kind == "perspective") {
    camera.half_extent = std::tan(field_of_view(parameters) * kPi / 360);
  } else if (kind == "spherical" && parameters.string("mapping", "equalarea") == "equirectangular") {
    camera.kind = CameraKind::panorama;
    camera.half_extent = kPi / 2;
    place_camera(camera, to_world);
  } else if (kind == "realistic" || kind == "spherical" || kind == "environment") {
    parameters.use_all();
    parameters.note(fmt::format("not supported, replaced by a perspective one: camera {}", in_quotes(kind)));
    camera.half_extent = std::tan(45 * kPi / 360);
    return camera;
  } else {
    parameters.error(fmt::format("unknown camera {}", in_quotes(kind)), "Supported: perspective and orthographic.");
    return camera;
  }
  set_window(camera, parameters);
  set_frame_aspect(camera, parameters);
  camera.lens_radius = std::max(parameters.real("lensradius", 0), 0.0f);
  camera.focal_distance = parameters.real("focaldistance", 1e6f);
  if (camera.lens_radius > 0 && !(camera.focal_distance > 0)) {
    parameters.error("focaldistance must be positive", "Give it in scene units.");
  }
  static_cast<void>(exposure_time(parameters));
  parameters.note_unused(fmt::format("camera {}", in_quotes(kind)));
  return camera;
}

void note_render_settings(std::string_view directive, const std::string& kind, const PbrtParameters& parameters,
                          FilmRequest& film) {
  if (directive == "Sampler") {
    const int samples = std::clamp(parameters.integer("pixelsamples", 0), 0, 1 << 20);
    if (samples == 0) return;
    film.samples = static_cast<std::uint32_t>(samples);
    parameters.note(
        fmt::format("used only as the default of --samples with --integrator path: pixelsamples {}", samples));
  } else if (directive == "Integrator") {
    if (parameters.has("maxdepth"))
      parameters.note(
          fmt::format("not supported, paths have no length limit: maxdepth {}", parameters.integer("maxdepth", 0)));
  } else if (directive == "PixelFilter") {
    // A box filter of one pixel, of any radius, is closest to the filter used here.
    if (kind != "box")
      parameters.note(fmt::format("not supported, replaced by a box of one pixel: pixel filter {}", in_quotes(kind)));
  }
}

FilmRequest make_film(const std::string& kind, const PbrtParameters& parameters, float exposure_seconds) {
  FilmRequest film;
  if (kind != "rgb" && kind != "image" && kind != "gbuffer" && kind != "spectral") {
    parameters.error(fmt::format("unknown film {}", in_quotes(kind)), "Supported: rgb, gbuffer and spectral.");
    return film;
  }
  constexpr int kLongestSide = 1 << 16;
  film.width = parameters.integer("xresolution", 1280);
  film.height = parameters.integer("yresolution", 720);
  if (film.width < 1 || film.height < 1 || film.width > kLongestSide || film.height > kLongestSide) {
    parameters.error(fmt::format("a picture of {} x {}", film.width, film.height),
                     fmt::format("Give sides between 1 and {} pixels.", kLongestSide));
    film.width = film.height = 0;
  }
  set_crop(film, parameters);
  // A scene file must not choose the folder for output.
  const std::string name = parameters.string("filename", "");
  film.file = name.substr(name.find_last_of('/') + 1);
  const std::string sensor = parameters.string("sensor", "cie1931");
  if (sensor != "cie1931") {
    parameters.note(fmt::format("not supported, only its exposure counts: sensor {}", in_quotes(sensor)));
  }
  if (parameters.has("whitebalance") && parameters.real("whitebalance", 0) != 0) {
    parameters.note("not supported: whitebalance of the film");
  }
  // PixelSensor::Create of pbrt-v4: exposure time times ISO / 100.
  film.scale = exposure_seconds * parameters.real("iso", 100) / 100 * parameters.real("scale", 1);
  for (const char* ignored : {"savefp16", "diagonal", "maxcomponentvalue", "coordinatesystem", "nbuckets", "lambdamin",
                              "lambdamax", "maxsampleluminance"}) {
    static_cast<void>(parameters.find(ignored));
  }
  parameters.note_unused(fmt::format("film {}", in_quotes(kind)));
  return film;
}

}  // namespace glowworm
