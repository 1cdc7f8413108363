#include "session/display.h"

#include <algorithm>
#include <bit>

#include "core/parallel.h"

namespace glowworm {

namespace {

/// Bits of a float that are left out: 11 of the 23 of its mantissa stay, far finer than 8-bit steps.
constexpr int kDropped = 12;
constexpr std::uint32_t kEntries = 0x7f800000u >> kDropped;
}  // namespace

void Display::tabulate(ToneCurve curve, float exposure) {
  if (tabulated_ && curve == curve_ && exposure == exposure_) return;
  table_.resize(kEntries);
  parallel_for_each(kEntries, 4096, [&](std::size_t i) {
    const auto value = std::bit_cast<float>((static_cast<std::uint32_t>(i) << kDropped) + (1u << (kDropped - 1)));
    table_[i] = to_byte(tone_map(RGB(value), curve, exposure).g);
  });
  tabulated_ = true;
  curve_ = curve;
  exposure_ = exposure;
}

const std::vector<std::uint8_t>& Display::view_bytes(const std::vector<RGB>& light, const ColorView& view,
                                                     float exposure) {
  const std::vector<std::uint8_t> shown = shown_by(view, light, exposure);
  bytes_.assign(4 * light.size(), 255);
  for (std::size_t i = 0; i < light.size(); ++i) std::copy_n(&shown[3 * i], 3, &bytes_[4 * i]);
  return bytes_;
}

const std::vector<std::uint8_t>& Display::bytes(const ViewFrame& frame, ToneCurve curve, float exposure,
                                                const ColorView* view) {
  if (frame.is_light && view) return view_bytes(frame.image.light, *view, exposure);
  if (frame.is_light)
    tabulate(curve, exposure);
  else
    tabulate(ToneCurve::srgb, 0);
  const std::vector<RGB>& light = frame.image.light;
  bytes_.resize(4 * light.size());
  // Negative numbers and NaN become black, infinity becomes white.
  const auto look_up = [&](float value) -> std::uint8_t {
    if (!(value > 0)) return 0;
    const std::uint32_t place = std::bit_cast<std::uint32_t>(value) >> kDropped;
    return place < kEntries ? table_[place] : 255;
  };
  parallel_for_each(light.size(), 4096, [&](std::size_t i) {
    bytes_[4 * i] = look_up(light[i].r);
    bytes_[4 * i + 1] = look_up(light[i].g);
    bytes_[4 * i + 2] = look_up(light[i].b);
    bytes_[4 * i + 3] = 255;
  });
  return bytes_;
}

}  // namespace glowworm
