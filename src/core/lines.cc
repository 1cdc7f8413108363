#include "core/lines.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

namespace glowworm {

namespace {

/// Removes the rest of a number that is not finite, such as the "#QNAN0" of Windows' "1.#QNAN0", and returns whether it
/// is one.
bool take_windows_word(std::string_view& text, double& value) {
  constexpr std::string_view kInfinite = "#INF", kWords[] = {kInfinite, "#QNAN", "#SNAN", "#IND"};
  for (const std::string_view word : kWords) {
    if (!text.starts_with(word)) continue;
    text.remove_prefix(word.size());
    while (text.starts_with('0')) text.remove_prefix(1);  // digits that a precision asks for
    value *= word == kInfinite ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  return false;
}

}  // namespace

std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

std::string_view take_line(std::string_view& text) {
  std::size_t end = 0;
  while (end < text.size() && text[end] != '\n' && text[end] != '\r') ++end;
  const std::string_view line = text.substr(0, end);
  if (end < text.size()) end += text.substr(end, 2) == "\r\n" ? 2 : 1;
  text.remove_prefix(end);
  return line;
}

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

std::string_view take_word(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
  text.remove_prefix(word.size());
  return word;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::string_view word = take_word(text); !word.empty(); word = take_word(text)) words.push_back(word);
  return words;
}

bool take_number(std::string_view& text, double& value) {
  std::string_view rest = text;
  if (rest.size() > 1 && rest.front() == '+' && rest[1] != '-') rest.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  if (error == std::errc::invalid_argument) return false;
  const std::string_view digits = rest.substr(0, static_cast<std::size_t>(end - rest.data()));
  rest.remove_prefix(digits.size());
  if (error == std::errc::result_out_of_range) {
    // Numbers this small or large have an exponent, or hundreds of digits in front of the point or zeros behind it.
    const std::size_t exponent = digits.find_first_of("eE");
    const bool small = exponent != std::string_view::npos ? digits.substr(exponent + 1).starts_with('-')
                                                          : digits.find_first_not_of("-0.") > digits.find('.');
    number = (digits.starts_with('-') ? -1 : 1) * (small ? 0 : std::numeric_limits<double>::infinity());
  } else if (rest.starts_with('#')) {
    take_windows_word(rest, number);
  }
  value = number;
  text = rest;
  return true;
}

}  // namespace glowworm
