#include "image/color_view.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "image/tone_map.h"

namespace glowworm {

namespace {

constexpr const char* kModule = "libglowworm_ocio.so";
constexpr std::size_t kPixelsAtOnce = 4096;

/// A number that views can take: the sums of a matrix stay finite. More than the largest number of half precision is
/// white in every view.
float exposed(float value, float gain) {
  constexpr float kMost = 65504;
  return std::isnan(value) ? 0 : std::clamp(value * gain, -kMost, kMost);
}

}  // namespace

std::shared_ptr<const ColorView> load_color_view(const ColorViewRequest& request) {
  void* const module = dlopen(kModule, RTLD_NOW | RTLD_LOCAL);
  void* const function = module ? dlsym(module, kOpenColorViewFunction) : nullptr;
  if (!function)
    throw Error(
        fmt::format("the library for OpenColorIO cannot be loaded ({})", dlerror()),
        fmt::format("Keep {} in the folder of the program, and install Debian's libopencolorio2.1, or use --tone.",
                    kModule));
  ColorViewFailure failure;
  std::shared_ptr<const ColorView> view(reinterpret_cast<OpenColorViewFunction*>(function)(request, failure));
  if (!view) throw Error({request.config}, failure.what, failure.advice);
  return view;
}

std::vector<std::uint8_t> shown_by(const ColorView& view, std::span<const RGB> pixels, float exposure) {
  const float gain = std::exp2(exposure);
  std::vector<std::uint8_t> bytes(3 * pixels.size());
  parallel_for(0, pixels.size(), kPixelsAtOnce, [&](std::size_t first, std::size_t last) {
    std::vector<RGB> shown(pixels.begin() + static_cast<std::ptrdiff_t>(first),
                           pixels.begin() + static_cast<std::ptrdiff_t>(last));
    for (RGB& pixel : shown) pixel = {exposed(pixel.r, gain), exposed(pixel.g, gain), exposed(pixel.b, gain)};
    view.apply(shown);
    for (std::size_t i = first; i < last; ++i)
      for (int c = 0; c < 3; ++c) bytes[3 * i + static_cast<std::size_t>(c)] = to_byte(shown[i - first][c]);
  });
  return bytes;
}

}  // namespace glowworm
