#include "core/text.h"

#include <fmt/format.h>

#include <filesystem>

namespace glowworm {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

std::string coordinate_text(float metres) {
  // Adding zero turns a zero below into one above, as people write it.
  return fmt::format("{:.{}g}", metres + 0.0f, std::abs(metres) < 1000 ? 4 : 7);
}

std::string lower_ending(const std::string& path) { return lower(std::filesystem::path(path).extension().string()); }

}  // namespace glowworm
