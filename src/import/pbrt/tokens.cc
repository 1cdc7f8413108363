#include "import/pbrt/tokens.h"

#include <charconv>
#include <cmath>

#include "core/lines.h"

namespace glowworm {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }
bool ends_word(char c) { return is_blank(c) || c == '"' || c == '[' || c == ']'; }
bool starts_number(char c) { return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.'; }

/// Parses all of `text` as a finite number. Underflow gives 0; overflow fails.
bool parse_number(std::string_view text, double& value) {
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc::result_out_of_range) {
    value = 0;  // on underflow; on overflow, the function fails
    return stop == end && text.find("e-") != std::string_view::npos;
  }
  return error == std::errc() && stop == end && std::isfinite(value);
}

}  // namespace

PbrtTokenizer::PbrtTokenizer(std::string_view text, const std::string* file, PbrtDiagnostics& diagnostics)
    : text_(text), at_(text.size() - without_byte_order_mark(text).size()), file_(file), diagnostics_(diagnostics) {
  line_start_ = at_;
}

PbrtPlace PbrtTokenizer::place() const { return {file_, line_, static_cast<int>(at_ - line_start_) + 1}; }

void PbrtTokenizer::skip_blanks() {
  for (; at_ < text_.size(); ++at_) {
    const char c = text_[at_];
    if (c == '#') {
      while (at_ < text_.size() && !is_line_end(text_[at_])) ++at_;
      if (at_ == text_.size()) return;
    } else if (!is_blank(c)) {
      return;
    }
    if (is_line_end(text_[at_]) && text_.substr(at_, 2) != "\r\n") {
      ++line_;
      line_start_ = at_ + 1;
    }
  }
}

bool PbrtTokenizer::scan_string(PbrtToken& token) {
  token.kind = PbrtTokenKind::string;
  const std::size_t first = ++at_;
  for (; at_ < text_.size() && !is_line_end(text_[at_]); ++at_) {
    const char c = text_[at_];
    if (c == '"') {
      token.text = text_.substr(first, at_ - first);
      ++at_;
      if (token.text.find('\0') == std::string_view::npos) return true;
      diagnostics_.error(token.place, "the string " + in_quotes(token.text) + " holds a NUL byte",
                         "Remove it; the file may be damaged or not a pbrt scene.");
      return false;
    }
    if (c == '\\' && at_ + 1 < text_.size() && !is_line_end(text_[at_ + 1])) {
      token.has_escapes = true;
      ++at_;
    }
  }
  diagnostics_.error(token.place, "the string " + in_quotes(text_.substr(first, at_ - first)) + " has no end",
                     "Close it with a double quote on the same line.");
  return false;
}

bool PbrtTokenizer::scan_word(PbrtToken& token) {
  const std::size_t first = at_;
  while (at_ < text_.size() && !ends_word(text_[at_])) ++at_;
  token.text = text_.substr(first, at_ - first);
  token.kind = PbrtTokenKind::word;
  if (!starts_number(token.text[0])) {
    bool printable = true;
    for (const char c : token.text) printable = printable && static_cast<unsigned char>(c) >= 0x20;
    if (printable) return true;
    diagnostics_.error(token.place, "unexpected bytes " + in_quotes(token.text),
                       "A pbrt scene is text; the file may be damaged or of another format.");
    return false;
  }
  token.kind = PbrtTokenKind::number;
  if (parse_number(token.text, token.number)) return true;
  diagnostics_.error(token.place, in_quotes(token.text) + " is not a number", "Write it like 1, -0.5 or 2.5e-3.");
  return false;
}

PbrtToken PbrtTokenizer::scan() {
  while (!diagnostics_.full()) {
    skip_blanks();
    PbrtToken token;
    token.place = place();
    if (at_ >= text_.size()) return token;
    const char c = text_[at_];
    if (c == '[' || c == ']') {
      token.kind = c == '[' ? PbrtTokenKind::left_bracket : PbrtTokenKind::right_bracket;
      token.text = text_.substr(at_++, 1);
      return token;
    }
    if (c == '"' ? scan_string(token) : scan_word(token)) return token;
  }
  PbrtToken end;
  end.place = place();
  return end;
}

PbrtToken PbrtTokenizer::next() {
  if (has_peeked_) {
    has_peeked_ = false;
    return peeked_;
  }
  return scan();
}

const PbrtToken& PbrtTokenizer::peek() {
  if (!has_peeked_) {
    peeked_ = scan();
    has_peeked_ = true;
  }
  return peeked_;
}

std::string unescape(const PbrtToken& token) {
  if (!token.has_escapes) return std::string(token.text);
  std::string out;
  for (std::size_t i = 0; i < token.text.size(); ++i) {
    char c = token.text[i];
    if (c == '\\' && i + 1 < token.text.size()) {
      constexpr std::string_view kNames = "ntrbf\\\"'", kMeanings = "\n\t\r\b\f\\\"'";
      const std::size_t known = kNames.find(token.text[++i]);
      if (known == std::string_view::npos) out += c;
      c = known == std::string_view::npos ? token.text[i] : kMeanings[known];
    }
    out += c;
  }
  return out;
}

}  // namespace glowworm
