// Ways on which an eye sees the sky, the sun among them, and lamps.
#pragma once
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "measure/glare.h"
#include "points/gather_points.h"
#include "scene/camera.h"
#include "trace/tracer.h"

namespace glowworm {

/// The sun's angular radius.
inline constexpr double kSunRadius = 0.2665 * M_PI / 180;

/// A way from the eye to the sky, through panes, and by smooth mirrors and glass.
struct SkyRay {
  std::uint32_t pixel = 0;  ///< of the picture, row by row
  Vec3 seen;                ///< unit, as GlareSource::direction
  Vec3 towards;             ///< unit, where the way leaves the scene
  float share = 0;          ///< of the sky's radiance that arrives
  float solid_angle = 0;    ///< sr, that it stands for in the picture
  bool bent = false;        ///< by mirrors or glass
};

/// The ways of a picture. Where a surface reflects and transmits, both are followed. Media weaken them.
/// @param camera is_angular() @param across ways along either side of a pixel
/// @param straight whether to return ways that are not bent, too
/// @param glints takes the surfaces with rough specular lobes at which ways end, by pixels in order: slots are pixels,
/// and throughputs are shares of a pixel; null: none
std::vector<SkyRay> sky_rays(const Tracer& tracer, const Camera& camera, int width, int height, int across,
                             bool straight, GatherPoints* glints = nullptr);

/// The light of lamps and sky, cd/m^2, within pixels: straight, and by panes, smooth mirrors and glass. Pixels that
/// show rough mirrors are left out.
/// @param camera is_angular() @param pixels ascending, row by row
std::vector<PixelDetail> light_within_pixels(const Tracer& tracer, const Camera& camera, int width, int height,
                                             std::span<const std::uint32_t> pixels);

/// The sun as sources of glare: seen straight, and by each mirror. The ways that end near the sun show its image in a
/// mirror, as if the sun were a larger disc of the same flux. The luminance of the image is the sun's times the share
/// that arrives. Its solid angle follows from the flux, so that curved mirrors make it smaller.
/// @param rays those that are not bent count for nothing
/// @param to_sun unit @param irradiance on a plane across the sunlight, W m^-2
std::vector<GlareSource> sources_of_sun(const Tracer& tracer, const Camera& camera, std::span<const SkyRay> rays,
                                        Vec3 to_sun, RGB irradiance);

}  // namespace glowworm
