#include "import/obj/lines.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>

namespace glowworm {

namespace {

constexpr std::string_view kBlank = " \t\r\v\f";

bool is_blank(char c) { return kBlank.find(c) != std::string_view::npos; }

std::string_view without_comment(std::string_view line) {
  for (std::size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1)) {
    if (at == 0 || is_blank(line[at - 1])) return line.substr(0, at);
  }
  return line;
}

}  // namespace

std::string_view LineReader::take_physical_line() {
  ++number_;
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

bool LineReader::next() {
  if (rest_.empty()) return false;
  line_ = take_physical_line();
  if (!line_.empty() && line_.back() == '\\') {
    joined_.clear();
    while (!line_.empty() && line_.back() == '\\') {
      joined_.append(line_.substr(0, line_.size() - 1)).push_back(' ');
      line_ = rest_.empty() ? std::string_view() : take_physical_line();
    }
    line_ = joined_.append(line_);
  }
  line_ = without_comment(line_);
  return true;
}

std::string_view next_word(std::string_view& rest) {
  std::size_t begin = 0;
  while (begin < rest.size() && is_blank(rest[begin])) ++begin;
  std::size_t end = begin;
  while (end < rest.size() && !is_blank(rest[end])) ++end;
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::optional<float> number_of(std::string_view word) {
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error == std::errc::invalid_argument || end != word.data() + word.size()) return std::nullopt;
  // strtod distinguishes overflow from underflow.
  if (error == std::errc::result_out_of_range) number = std::strtod(std::string(word).c_str(), nullptr);
  return static_cast<float>(number);
}

}  // namespace glowworm
