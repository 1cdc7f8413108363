#include "core/text.h"

#include <filesystem>

namespace glowworm {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

std::string lower_ending(const std::string& path) { return lower(std::filesystem::path(path).extension().string()); }

}  // namespace glowworm
