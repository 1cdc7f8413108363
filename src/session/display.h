// From a frame to the bytes of a display.
#pragma once
#include <cstdint>
#include <vector>

#include "image/color_view.h"
#include "image/tone_map.h"
#include "session/view_frame.h"

namespace glowworm {

/// The tone curve of a display as a table, for speed.
class Display {
 public:
  /// 8-bit RGBA of a frame, row by row from the top; within one step of what write_png() writes. @param exposure stops
  /// @param view shows light instead of the curve, or null
  const std::vector<std::uint8_t>& bytes(const ViewFrame& frame, ToneCurve curve, float exposure,
                                         const ColorView* view = nullptr);

 private:
  const std::vector<std::uint8_t>& view_bytes(const std::vector<RGB>& light, const ColorView& view, float exposure);
  void tabulate(ToneCurve curve, float exposure);

  bool tabulated_ = false;
  ToneCurve curve_ = ToneCurve::filmic;
  float exposure_ = 0;
  std::vector<std::uint8_t> table_;  // by the upper bits of a float that is not negative
  std::vector<std::uint8_t> bytes_;
};

}  // namespace glowworm
