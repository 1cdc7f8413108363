#include "session/view_image.h"

#include <algorithm>

#include "core/parallel.h"
#include "session/camera_control.h"

namespace glowworm {

namespace {
/// Distance in metres that stands for infinity: its square is a float.
constexpr float kFar = 1e9f;
constexpr std::size_t kRows = 8;
}  // namespace

void ViewImage::find_positions() {
  position.resize(size());
  parallel_for_each(static_cast<std::size_t>(height), kRows, [&](std::size_t y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t i = y * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
      const Vec2 film{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
      position[i] = unproject(camera, film, width, height, std::min(depth[i], kFar));
    }
  });
}

}  // namespace glowworm
