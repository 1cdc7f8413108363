// Writes Radiance pictures: RGBE pixels in scanlines with run lengths (Ward, "Real Pixels", Graphics Gems II, 1991).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/atomic_file.h"
#include "core/error.h"
#include "image/image.h"

namespace glowworm {

namespace {

/// Widths of scanlines that may be packed, and the longest runs of equal and of different bytes.
constexpr int kFewestPacked = 8, kMostPacked = 0x7fff;
constexpr std::size_t kLongestRun = 127, kLongestDump = 128, kShortestRun = 4;

using Rgbe = std::array<std::uint8_t, 4>;

Rgbe rgbe_of(RGB c) {
  // The format holds neither negative numbers nor infinity.
  const float channels[3] = {std::max(c.r, 0.0f), std::max(c.g, 0.0f), std::max(c.b, 0.0f)};
  const float most = std::max({channels[0], channels[1], channels[2]});
  constexpr float kLeast = 1e-32f, kMost = 1e38f;
  if (!(most >= kLeast)) return {0, 0, 0, 0};
  int exponent = 0;
  (void)std::frexp(std::min(most, kMost), &exponent);
  Rgbe out{0, 0, 0, static_cast<std::uint8_t>(exponent + 128)};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = static_cast<std::uint8_t>(std::min(std::ldexp(std::min(channels[i], kMost), 8 - exponent), 255.0f));
  return out;
}

/// Appends one channel of a scanline: runs of equal bytes as 128 plus their length and the byte, others as their number
/// and themselves.
void pack(std::string& to, const std::vector<std::uint8_t>& bytes) {
  const auto run_at = [&](std::size_t at) {
    std::size_t end = at;
    while (end < bytes.size() && end - at < kLongestRun && bytes[end] == bytes[at]) ++end;
    return end - at;
  };
  for (std::size_t at = 0; at < bytes.size();) {
    if (const std::size_t run = run_at(at); run >= kShortestRun) {
      to += static_cast<char>(128 + run);
      to += static_cast<char>(bytes[at]);
      at += run;
      continue;
    }
    std::size_t end = at;
    while (end < bytes.size() && end - at < kLongestDump && run_at(end) < kShortestRun) ++end;
    to += static_cast<char>(end - at);
    to.append(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.begin() + static_cast<std::ptrdiff_t>(end));
    at = end;
  }
}

void add_scanline(std::string& to, std::span<const RGB> row) {
  const int width = static_cast<int>(row.size());
  if (width < kFewestPacked || width > kMostPacked) {
    for (const RGB& pixel : row)
      for (const std::uint8_t byte : rgbe_of(pixel)) to += static_cast<char>(byte);
    return;
  }
  to += {2, 2, static_cast<char>(width >> 8), static_cast<char>(width & 255)};
  std::vector<std::uint8_t> channels[4];
  for (const RGB& pixel : row) {
    const Rgbe bytes = rgbe_of(pixel);
    for (std::size_t c = 0; c < 4; ++c) channels[c].push_back(bytes[c]);
  }
  for (const auto& channel : channels) pack(to, channel);
}

}  // namespace

void write_hdr(const std::string& path, const Image& image) {
  check_not_empty(path, image);
  const std::vector<RGB> pixels = image.rgb();
  std::string bytes = "#?RADIANCE\n";
  const auto found = image.metadata.find(kRadianceView);
  for (const char* key : {"comments", "Software"})
    if (const auto text = image.metadata.find(key); text != image.metadata.end()) {
      std::string line = text->second;
      std::replace_if(
          line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
      bytes += (key[0] == 'S' ? "SOFTWARE= " : "") + line + "\n";
    }
  if (found != image.metadata.end()) bytes += fmt::format("VIEW= {}\n", found->second);
  if (image.radiance_scale > 0) bytes += fmt::format("EXPOSURE={:e}\n", image.radiance_scale);
  bytes += "PRIMARIES= 0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329\nFORMAT=32-bit_rle_rgbe\n\n";
  bytes += fmt::format("-Y {} +X {}\n", image.height(), image.width());
  const auto width = static_cast<std::size_t>(image.width());
  for (std::size_t y = 0; y < static_cast<std::size_t>(image.height()); ++y)
    add_scanline(bytes, std::span(pixels).subspan(y * width, width));
  write_file(path, bytes);
}

}  // namespace glowworm
