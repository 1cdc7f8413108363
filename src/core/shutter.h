// The time for which a camera's shutter is open.
#pragma once
#include <cstdint>
#include <string>

namespace glowworm {

/// Times of a shutter, s from the moment of a frame.
struct Shutter {
  double open = 0, close = 0;

  /// A moment of one of `slices` equal slices of the time: slice `slice`, from 0, at a random place within it.
  double moment(std::uint32_t slice, std::uint32_t slices, std::uint32_t seed) const;
  bool operator==(const Shutter&) const = default;
};

/// Reads an exposure time such as "0.02" or "1/48", or "OPEN:CLOSE", s. Throws Error if the text is neither.
Shutter parse_shutter(const std::string& text);

}  // namespace glowworm
