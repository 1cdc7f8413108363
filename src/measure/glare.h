// Glare of a view: sources in a fisheye picture, and the indices that rate them.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transform_double.h"
#include "core/vec.h"
#include "scene/camera.h"

namespace glowworm {

/// Luminances at places of a pixel.
struct PixelDetail {
  static constexpr int kAcross = 4;
  std::uint32_t pixel = 0;                           ///< row by row
  std::array<float, kAcross * kAcross> luminance{};  ///< cd/m^2
};

/// Luminance of a fisheye picture around the direction of view.
struct GlarePicture {
  CameraKind kind = CameraKind::fisheye;  ///< or hemispherical
  int width = 0, height = 0;
  float half_x = kPi / 2, half_y = kPi / 2;  ///< of the picture plane (Camera::half_extent) along its sides
  std::vector<float> luminance;              ///< cd/m^2, row-major, first row on top
  std::vector<PixelDetail> details;          ///< of some pixels, whose `luminance` is their mean
};

/// A source of glare.
struct GlareSource {
  Vec3 direction;          ///< unit, from the eye: x to the right, y up, z along the view
  double solid_angle = 0;  ///< sr
  double luminance = 0;    ///< cd/m^2, mean over the solid angle
  double position_index = 1;
  double illuminance = 0;  ///< lx, on the plane across the view
};

/// What rates the glare of a view.
struct Glare {
  double vertical_illuminance = 0;  ///< lx, on the plane across the view
  double background = 0;            ///< cd/m^2: illuminance without the sources, over pi
  double dgp = 0, dgi = 0, ugr = 0;
  std::vector<GlareSource> sources;
  std::vector<std::uint32_t> source_of;  ///< of each pixel; kNoGlareSource
};
inline constexpr std::uint32_t kNoGlareSource = 0xffffffffu;

/// Where sources begin, cd/m^2: the numbers that evalglare takes without a task area (evalglare 2 of Radiance,
/// src/util/evalglare.c). Unlike here, it joins pixels up to 0.2 rad apart to one source.
inline constexpr double kGlareThreshold = 2000, kGlarePeak = 50'000;

/// Where sources begin beside a task, over its mean luminance, as evalglare's manual has it with -t and -b 5.
inline constexpr double kTaskFactor = 5;

/// A circle in a picture that shows what the eye works on.
struct GlareTask {
  double x = 0, y = 0;   ///< its middle, pixels from the lower left corner
  double opening = 0.5;  ///< the angle across it, radians
};
/// Mean luminance of a task over its solid angle, cd/m^2. Throws Error where the picture shows nothing of it.
double task_luminance(const GlarePicture& picture, const GlareTask& task);

/// The position index of a direction: above the line of sight that of Guth (as in the IES Lighting Handbook), below
/// it that of Iwata and Tokura (1997); at most 16.
/// @param direction unit, x to the right, y up, z along the view
double position_index(Vec3 direction);

/// What a pixel shows of the half space in front of the eye.
struct PixelView {
  double solid_angle = 0;  ///< sr
  Vec3d projected;         ///< integral of the direction over it
};
/// Of each pixel of a picture; its luminance is not read.
std::vector<PixelView> pixel_views(const GlarePicture& picture);

/// Sources are connected pixels above the threshold; those above kGlarePeak are sources of their own, such as the sun
/// in a bright sky. Of a pixel with details, the brightest part counts alone.
/// @param views pixel_views() of the picture, or of another of its kind and size
/// @param threshold cd/m^2; @param lights beside those of the picture, such as the sun, whose disc is less than a pixel
Glare rate_glare(const GlarePicture& picture, std::span<const PixelView> views,
                 std::span<const GlareSource> lights = {}, double threshold = kGlareThreshold);
inline Glare rate_glare(const GlarePicture& picture, std::span<const GlareSource> lights = {},
                        double threshold = kGlareThreshold) {
  return rate_glare(picture, pixel_views(picture), lights, threshold);
}

/// Daylight glare probability (Wienold and Christoffersen, Energy and Buildings 38(7), 2006), with evalglare's
/// low-light correction below 1000 lx at the eye (Wienold, "Daylight glare in offices", 2009).
double daylight_glare_probability(double vertical_illuminance, std::span<const GlareSource> sources);
/// Daylight glare index (Hopkinson, Applied Ergonomics 3, 1972). 0 without sources.
double daylight_glare_index(double background, std::span<const GlareSource> sources);
/// Unified glare rating (CIE 117:1995). 0 without sources.
double unified_glare_rating(double background, std::span<const GlareSource> sources);

}  // namespace glowworm
