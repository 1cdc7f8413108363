#include "core/shutter.h"

#include <fmt/format.h>

#include <optional>

#include "core/error.h"
#include "core/random.h"
#include "core/text.h"

namespace glowworm {

namespace {

/// A number, or a fraction of two; nothing if the text is neither.
std::optional<double> read_seconds(const std::string& text) {
  const std::vector<double> parts = numbers_of<double>(text, '/');
  if (parts.empty() || parts.size() > 2 || (parts.size() == 2 && !(parts[1] > 0))) return std::nullopt;
  return parts.size() == 2 ? parts[0] / parts[1] : parts[0];
}

}  // namespace

double Shutter::moment(std::uint32_t slice, std::uint32_t slices, std::uint32_t seed) const {
  constexpr std::uint32_t kTime = 0x74696d65u;
  const double within = to_unit_float(hash_combine(hash_combine(kTime, seed), slice));
  return open + (close - open) * (slice + within) / slices;
}

Shutter parse_shutter(const std::string& text) {
  const std::size_t colon = text.find(':');
  const bool has_both = colon != std::string::npos;
  const std::optional<double> open = has_both ? read_seconds(text.substr(0, colon)) : 0.0;
  const std::optional<double> close = read_seconds(has_both ? text.substr(colon + 1) : text);
  constexpr double kLongest = 3600;
  if (!open || !close || *close < *open || (*close == *open && *open != 0) || *open < -kLongest || *close > kLongest)
    throw Error(fmt::format("--shutter '{}' is not a time", text),
                "Give the seconds that it is open, such as 0.02 or 1/48, or when it opens and closes, such as "
                "-0.01:0.01; at most an hour.");
  return {*open, *close};
}

}  // namespace glowworm
