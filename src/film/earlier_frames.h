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

/// What later frames need of a frame; entries as in FilterGuides.
struct FrameLight {
  FrameView view;
  FilterGuides guides;
  LightEstimate direct, indirect;
};

/// A view, and frames of the same scene in the same light that it may use.
struct EarlierFrames {
  FrameView view;
  std::vector<std::shared_ptr<const FrameLight>> frames;

  EarlierFrames(FrameView view, std::vector<std::shared_ptr<const FrameLight>> frames)
      : view(std::move(view)), frames(std::move(frames)) {}
};

/// Adds samples of earlier frames to each pixel: from the pixel that showed the same place of a surface, if the light
/// around both is the same as far as their statistics tell. Its samples count as much as the pixel's own, so the error
/// that a wrong answer adds is no larger than the noise that it removes.
///
/// The mean square of the differences of 3 x 3 pixels, over the variances, tells a shifted edge; their sum tells a
/// reflection that has moved.
/// @param guides of the pixels of `earlier.view`; a NaN normal takes no samples
/// @param layer of FrameLight that `estimate` is
void add_earlier_samples(const EarlierFrames& earlier, const FilterGuides& guides, LightEstimate FrameLight::*layer,
                         LightEstimate& estimate);

/// Bytes of a FrameLight for each pixel.
inline constexpr std::size_t kFrameLightBytes =
    sizeof(Vec3) + sizeof(float) + 2 * (sizeof(RGB) + 2 * sizeof(float) + sizeof(std::uint32_t));

}  // namespace glowworm
