// Values of the command line, as people write them: 500k, 4G, 5m, 1280x720.
#pragma once
#include <cstdint>
#include <string>

namespace glowworm {

/// A count: "auto" is 0; otherwise a whole number from 1 to `largest`, with k or M for thousands or millions. All
/// functions here throw Error that names the option and gives an example.
std::uint64_t parse_count(const std::string& text, const std::string& option, std::uint64_t largest);

/// A size in bytes: K, M, G, T (or KB, ...) are powers of 1000, KiB, MiB, GiB, TiB powers of 1024. At least 1 MB.
std::uint64_t parse_bytes(const std::string& text, const std::string& option);

/// A time in seconds: "90", "90s", "5m" (or min), "2h".
double parse_seconds(const std::string& text, const std::string& option);

struct PixelSize {
  int width = 0, height = 0;
};
/// A picture size in pixels, "1280x720".
PixelSize parse_pixel_size(const std::string& text, const std::string& option);

}  // namespace glowworm
