// Gathered light of earlier frames of a sequence, used again where it is the same light.
#pragma once
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "filter/light_filter.h"
#include "scene/camera.h"
#include "settings/settings.h"

namespace glowworm {

/// A frame's view: its pixels lie within a picture.
struct FrameView {
  Camera camera;
  int width = 0, height = 0;  ///< of the picture
  PixelBounds bounds;         ///< of the frame's pixels
};

/// What a pixel shows beside gathered light: means over its samples.
struct PixelSurface {
  RGB albedo, shown;     ///< albedo of camera samples, and of surface samples (gather/camera_pass.h)
  RGB caustic, emitted;  ///< W sr^-1 m^-2; light of a single sun is with emission
  float variance = 0;    ///< of the pixel's luminance, without that of gathered light and of media
};

/// What later frames need of a frame; entries as in FilterGuides.
struct FrameLight {
  FrameView view;
  FilterGuides guides;
  LightEstimate direct, indirect;
  LightEstimate medium;  ///< light of media; empty if there are none
  std::vector<PixelSurface> surfaces;
};

using FrameLights = std::vector<std::shared_ptr<const FrameLight>>;

/// A view, and frames of the same scene in the same light that it may use.
struct EarlierFrames {
  FrameView view;
  FrameLights frames;

  EarlierFrames(FrameView view, FrameLights frames) : view(std::move(view)), frames(std::move(frames)) {}
  /// Frames that show the same picture, whose samples are further samples of all that a pixel shows.
  FrameLights of_same_view() const;
};

/// Adds samples of earlier frames to each pixel: from the pixel that showed the same place of a surface, if the light
/// around both is the same as far as their statistics tell, or the frame had the same view. Its samples count as much
/// as the pixel's own, so the error that a wrong answer adds is no larger than the noise that it removes.
///
/// The mean square of the differences of 3 x 3 pixels, over the variances, tells a shifted edge; their sum tells a
/// reflection that has moved.
/// @param guides of the pixels of `earlier.view`; a NaN normal takes no samples
/// @param layer of FrameLight that `estimate` is
void add_earlier_samples(const EarlierFrames& earlier, const FilterGuides& guides, LightEstimate FrameLight::*layer,
                         LightEstimate& estimate);

/// Adds samples of frames to each pixel. @param same_view frames of the same picture @param layer as above
void add_same_view(const FrameLights& same_view, LightEstimate FrameLight::*layer, LightEstimate& estimate);

/// What a pixel shows, by its own samples and those of frames of the same picture.
/// @param samples the pixel's own; those of the frames are added
PixelSurface with_same_view(const FrameLights& same_view, std::size_t pixel, PixelSurface own, std::uint32_t& samples);

/// Bytes of a FrameLight for each pixel.
inline constexpr std::size_t kFrameLightBytes =
    sizeof(Vec3) + sizeof(float) + 3 * (sizeof(RGB) + 2 * sizeof(float) + sizeof(std::uint32_t)) + sizeof(PixelSurface);

}  // namespace glowworm
