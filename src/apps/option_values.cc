#include "apps/option_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string_view>

#include "core/error.h"

namespace glowworm {

namespace {

struct Unit {
  std::string_view name;
  double factor;
};

/// A decimal number with one of the units behind it, times the unit's factor; not a number where it is none.
double parse_quantity(std::string_view text, std::initializer_list<Unit> units) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  if (error == std::errc())
    for (const Unit& known : units)
      if (unit == known.name) return value * known.factor;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::uint64_t parse_count(const std::string& text, const std::string& option, std::uint64_t largest) {
  if (text == "auto") return 0;
  const double value = parse_quantity(text, {{"", 1}, {"k", 1e3}, {"M", 1e6}});
  if (!(value >= 1 && value <= static_cast<double>(largest)) || value != std::floor(value))
    throw Error(fmt::format("{} '{}' is not a count", option, text),
                fmt::format("Give 'auto' or a whole number from 1 to {}; 2k is 2000 and 1.5M is 1500000.", largest));
  return static_cast<std::uint64_t>(value);
}

std::uint64_t parse_bytes(const std::string& text, const std::string& option) {
  constexpr double kKibi = 1024;
  const double value = parse_quantity(text, {{"", 1},
                                             {"K", 1e3},
                                             {"KB", 1e3},
                                             {"KiB", kKibi},
                                             {"M", 1e6},
                                             {"MB", 1e6},
                                             {"MiB", kKibi * kKibi},
                                             {"G", 1e9},
                                             {"GB", 1e9},
                                             {"GiB", kKibi * kKibi * kKibi},
                                             {"T", 1e12},
                                             {"TB", 1e12},
                                             {"TiB", kKibi * kKibi * kKibi * kKibi}});
  if (!(value >= 1e6 && value <= 1e15))
    throw Error(fmt::format("{} '{}' is not a size", option, text), "Give at least 1M, for example 512M or 4G.");
  return static_cast<std::uint64_t>(value);
}

double parse_seconds(const std::string& text, const std::string& option) {
  const double value = parse_quantity(text, {{"", 1}, {"s", 1}, {"m", 60}, {"min", 60}, {"h", 3600}});
  if (!(value > 0 && value <= 1e9))
    throw Error(fmt::format("{} '{}' is not a time", option, text), "Give for example 60s, 5m or 2h.");
  return value;
}

PixelSize parse_pixel_size(const std::string& text, const std::string& option) {
  PixelSize size;
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  bool good = width.ec == std::errc() && width.ptr != end && *width.ptr == 'x';
  if (good) {
    const auto height = std::from_chars(width.ptr + 1, end, size.height);
    good = height.ec == std::errc() && height.ptr == end && size.width > 0 && size.height > 0;
  }
  if (!good)
    throw Error(fmt::format("{} '{}' is not a size", option, text),
                "Give WIDTHxHEIGHT in pixels, both at least 1, for example 1280x720.");
  return size;
}

}  // namespace glowworm
