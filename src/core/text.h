// Numbers and names in texts.
#pragma once
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace glowworm {

/// The text with the letters A to Z in lower case.
std::string lower(std::string_view text);
/// The ending of a file's name in lower case: ".png" of "a/B.PNG".
std::string lower_ending(const std::string &path);

/// A word as a shell takes it: in single quotes if it would split or expand the word.
std::string shell_word(const std::string &word);

/// The text without what commands a terminal: control characters other than tabs and line breaks, characters that
/// change the direction of writing, and bytes that are not UTF-8 become escapes such as \x1b.
std::string printable(std::string_view text);

/// A coordinate in metres: four digits, and millimetres from a thousand metres on.
std::string coordinate_text(double metres);

/// Finite numbers with a separator between them; empty if the text is anything else.
template <typename T>
std::vector<T> numbers_of(std::string_view text, char separator = ',') {
  std::vector<T> out;
  for (const char *at = text.data(), *const end = at + text.size();; ++at) {
    T value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) return {};
    out.push_back(value);
    if (next == end) return out;
    if (*next != separator) return {};
    at = next;
  }
}

}  // namespace glowworm
