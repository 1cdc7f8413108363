// Views of OpenColorIO: how a config shows linear light on a display.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/rgb.h"
#include "image/image.h"

namespace glowworm {

/// A view of a config, instead of a tone curve. Any thread may call its functions.
class ColorView {
 public:
  virtual ~ColorView() = default;
  /// Replaces linear RGB (Rec. 709) by encoded values of the display.
  virtual void apply(std::span<RGB> pixels) const = 0;
  /// Names of the view and its display, for messages.
  virtual std::string name() const = 0;
};

/// What to load. The empty display or view is the config's default.
struct ColorViewRequest {
  std::string config, display, view;
};

/// Loads a view. Pixels enter a config by its role aces_interchange; one without this role is expected to have Rec. 709
/// primaries in its role scene_linear. Loads the library of OpenColorIO, so that programs without --ocio need none.
/// Throws Error, which names the config, if it cannot be read or has no such display or view.
std::shared_ptr<const ColorView> load_color_view(const ColorViewRequest& request);

/// 8-bit RGB of linear pixels as a view shows them. NaN becomes 0. @param exposure stops, applied first
std::vector<std::uint8_t> shown_by(const ColorView& view, std::span<const RGB> pixels, float exposure);

/// Writes the beauty as the view shows it, as write_png() does. The file does not say which display its codes are for.
void write_png(const std::string& path, const Image& image, const ColorView& view, float exposure);

/// Why the module has no view.
struct ColorViewFailure {
  std::string what, advice;
};

/// Function of the module that OpenColorIO is used by; it stands beside the program. Returns a new object, or null.
inline constexpr const char* kOpenColorViewFunction = "glowworm_open_color_view";
using OpenColorViewFunction = ColorView*(const ColorViewRequest&, ColorViewFailure&);

}  // namespace glowworm
