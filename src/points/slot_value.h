// Numbers of a slot that a pass finds on request.
#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// Numbers that a pass finds for each slot on request, in addition to light and first hits. A new one takes its row in
/// kSlotValueNames, the code that fills FirstHit::values after the camera pass, which clears them, and a layer
/// (film/aov.cc).
enum class SlotValue : std::uint8_t {
  radius,  ///< mean radius of the photons around the gather point, metres
  bias,    ///< estimated bias of the luminance by the photons' radii, W sr^-1 m^-2
};
inline constexpr std::array kSlotValueNames = {"radius", "bias"};
inline constexpr std::size_t kSlotValues = kSlotValueNames.size();

/// A set of these numbers.
class SlotValues {
 public:
  constexpr SlotValues() = default;
  constexpr SlotValues(SlotValue value) : bits_(1u << static_cast<unsigned>(value)) {}
  constexpr bool has(SlotValue value) const { return has(static_cast<std::size_t>(value)); }
  constexpr bool has(std::size_t value) const { return (bits_ >> value & 1u) != 0; }
  constexpr bool empty() const { return bits_ == 0; }
  constexpr int count() const { return std::popcount(bits_); }
  constexpr SlotValues& operator|=(SlotValues other) {
    bits_ |= other.bits_;
    return *this;
  }
  bool operator==(const SlotValues&) const = default;

 private:
  unsigned bits_ = 0;
};

}  // namespace glowworm
