#include "import/ies/photometric_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr const char* kDamaged = "The file may be damaged or cut off; fetch it again.";

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ','; }

}  // namespace

PhotometricText::PhotometricText(std::string_view text, std::string path) : text_(text), path_(std::move(path)) {
  if (text_.starts_with("\xef\xbb\xbf")) place_ = 3;  // byte order mark, written by some editors
}

void PhotometricText::fail(const std::string& message) const { throw Error({path_, line_}, message, kDamaged); }

void PhotometricText::fail_at_end(const char* what) const {
  throw Error({path_, line_}, fmt::format("the file ends at {}", what),
              "The file may be cut off; fetch it again. A whole file has a line end behind its last line.");
}

std::string_view PhotometricText::line(const char* what) {
  const std::size_t end = text_.find_first_of("\r\n", place_);
  if (end == std::string_view::npos) fail_at_end(what);
  const std::string_view line = text_.substr(place_, end - place_);
  const bool both = text_[end] == '\r' && end + 1 < text_.size() && text_[end + 1] == '\n';
  place_ = end + (both ? 2 : 1);
  ++line_;
  return line;
}

float PhotometricText::value_of(std::string_view word, const char* what) const {
  if (word.starts_with('+')) word.remove_prefix(1);
  float value = 0;
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range && rest == word.data() + word.size())
    fail(fmt::format("'{}' is too large or too small, as {}", word, what));
  if (error != std::errc() || rest != word.data() + word.size() || !std::isfinite(value))
    fail(fmt::format("'{}' is no number, where {} is expected", word.substr(0, 40), what));
  return value;
}

float PhotometricText::number(const char* what) {
  for (; place_ < text_.size() && is_blank(text_[place_]); ++place_)
    if (text_[place_] == '\n' || (text_[place_] == '\r' && text_.substr(place_, 2) != "\r\n")) ++line_;
  const std::size_t begin = place_;
  while (place_ < text_.size() && !is_blank(text_[place_])) ++place_;
  if (place_ == text_.size()) fail_at_end(what);
  return value_of(text_.substr(begin, place_ - begin), what);
}

std::optional<float> PhotometricText::number_or_blank(const char* what, bool may_be_blank) {
  std::string word(line(what));
  --line_;  // for the error
  while (!word.empty() && is_blank(word.back())) word.pop_back();
  while (!word.empty() && is_blank(word.front())) word.erase(word.begin());
  if (const std::size_t comma = word.find(','); comma != std::string::npos) word[comma] = '.';
  std::optional<float> value;
  if (!word.empty() || !may_be_blank) value = value_of(word, what);
  ++line_;
  return value;
}

float PhotometricText::number_line(const char* what) { return *number_or_blank(what, false); }

void PhotometricText::skip_number_lines(const char* what, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) number_or_blank(what, true);
}

int PhotometricText::count(const char* what, float value, int least, int most) const {
  if (!(value >= static_cast<float>(least) && value <= static_cast<float>(most)) || value != std::floor(value))
    fail(fmt::format("{:g} is {}, where a whole number from {} to {} is expected", value, what, least, most));
  return static_cast<int>(value);
}

void PhotometricText::check_room(const char* what, std::size_t count) const {
  // A digit and what stands behind it.
  if (count > (text_.size() - place_) / 2) fail_at_end(what);
}

std::vector<float> PhotometricText::numbers(const char* what, std::size_t count) {
  check_room(what, count);
  std::vector<float> out(count);
  for (float& value : out) value = number(what);
  return out;
}

std::vector<float> PhotometricText::number_lines(const char* what, std::size_t count) {
  check_room(what, count);
  std::vector<float> out(count);
  for (float& value : out) value = number_line(what);
  return out;
}

}  // namespace glowworm
