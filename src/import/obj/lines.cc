#include "import/obj/lines.h"

namespace glowworm {

namespace {

std::string_view without_comment(std::string_view line) {
  for (std::size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1)) {
    if (at == 0 || kBlanks.find(line[at - 1]) != kBlanks.npos) return line.substr(0, at);
  }
  return line;
}

}  // namespace

LineReader::LineReader(std::string_view text) : rest_(without_byte_order_mark(text)) {}

std::string_view LineReader::take_physical_line() {
  ++number_;
  return take_line(rest_);
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

std::string_view next_name(std::string_view& rest) {
  rest = trimmed(rest);
  const std::size_t quote = rest.starts_with('"') ? rest.find('"', 1) : std::string_view::npos;
  if (quote == std::string_view::npos) return take_word(rest);
  const std::string_view name = rest.substr(1, quote - 1);
  rest.remove_prefix(quote + 1);
  return name;
}

std::string_view name_of(std::string_view text) {
  text = trimmed(text);
  const bool quoted = text.size() > 1 && text.front() == '"' && text.find('"', 1) == text.size() - 1;
  return quoted ? text.substr(1, text.size() - 2) : text;
}

std::optional<double> number_of(std::string_view word) {
  double number = 0;
  if (!take_number(word, number) || !word.empty()) return std::nullopt;
  return number;
}

std::optional<float> float_of(std::string_view word) {
  const std::optional<double> number = number_of(word);
  return number ? std::optional(static_cast<float>(*number)) : std::nullopt;
}

}  // namespace glowworm
