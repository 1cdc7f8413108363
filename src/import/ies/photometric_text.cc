#include "import/ies/photometric_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/lines.h"

namespace glowworm {

namespace {

constexpr const char* kDamaged = "The file may be damaged or cut off; fetch it again.";

/// What stands between numbers: blanks, commas, and DOS's mark of a file's end.
constexpr std::string_view kBetweenNumbers = " \t\r\n,\x1a";

bool is_blank(char c) { return kBetweenNumbers.find(c) != std::string_view::npos; }

}  // namespace

PhotometricText::PhotometricText(std::string_view text, std::string path)
    : text_(without_byte_order_mark(text)), path_(std::move(path)) {}

void PhotometricText::fail(const std::string& message) const { throw Error({path_, line_}, message, kDamaged); }

void PhotometricText::fail_at_end(const char* what) const {
  throw Error({path_, line_}, fmt::format("the file ends at {}", what), "The file may be cut off; fetch it again.");
}

std::string_view PhotometricText::line(const char* what) {
  if (place_ == text_.size()) fail_at_end(what);
  const std::size_t end = std::min(text_.find_first_of("\r\n", place_), text_.size());
  const std::string_view line = text_.substr(place_, end - place_);
  const bool both = text_.substr(end, 2) == "\r\n";
  place_ = std::min(end + (both ? 2 : 1), text_.size());
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

void PhotometricText::skip_blanks() {
  for (; place_ < text_.size() && is_blank(text_[place_]); ++place_)
    if (text_[place_] == '\n' || (text_[place_] == '\r' && text_.substr(place_, 2) != "\r\n")) ++line_;
}

float PhotometricText::number(const char* what) {
  skip_blanks();
  if (place_ == text_.size()) fail_at_end(what);
  const std::size_t begin = place_;
  while (place_ < text_.size() && !is_blank(text_[place_])) ++place_;
  return value_of(text_.substr(begin, place_ - begin), what);
}

void PhotometricText::check_end(const char* what) {
  skip_blanks();
  float value = 0;
  const std::string_view rest = text_.substr(place_).substr(0, 40);
  const char* const begin = rest.data() + rest.starts_with('+');
  if (std::from_chars(begin, rest.data() + rest.size(), value).ec == std::errc::invalid_argument) return;
  fail(fmt::format("'{}' stands behind {}: the file has more numbers than it says",
                   rest.substr(0, rest.find_first_of(" \t\r\n,")), what));
}

std::optional<float> PhotometricText::number_or_blank(const char* what, bool may_be_blank) {
  std::string word(trimmed(line(what), kBetweenNumbers));
  --line_;  // for the error
  if (const std::size_t comma = word.find(','); comma != std::string::npos) word[comma] = '.';
  std::optional<float> value;
  if (!word.empty() || !may_be_blank) value = value_of(word, what);
  ++line_;
  return value;
}

float PhotometricText::number_line(const char* what) { return *number_or_blank(what, false); }

std::vector<float> PhotometricText::optional_number_lines(const char* what, std::size_t count) {
  std::vector<float> out(count);
  for (float& value : out) value = number_or_blank(what, true).value_or(0.0f);
  return out;
}

int PhotometricText::count(const char* what, float value, int least, int most) const {
  if (!(value >= static_cast<float>(least) && value <= static_cast<float>(most)) || value != std::floor(value))
    fail(fmt::format("{:g} is {}, where a whole number from {} to {} is expected", value, what, least, most));
  return static_cast<int>(value);
}

void PhotometricText::check_room(const char* what, std::size_t count) const {
  // A digit and, but for the last, what stands behind it.
  if (count > (text_.size() - place_ + 1) / 2) fail_at_end(what);
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

std::vector<std::size_t> settle_angles(std::vector<float>& angles, float least, float most) {
  std::vector<float> settled;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    float angle = std::clamp(angles[i], least, most);
    const float quarter = 90 * std::round(angle / 90);
    if ((i == 0 || i + 1 == angles.size()) && std::abs(angle - quarter) < kAngleRounding) angle = quarter;
    if (i > 0 && angle == settled.back()) {
      if (angle == angles[i]) kept.back() = i;  // the one that was not moved
      continue;
    }
    settled.push_back(angle);
    kept.push_back(i);
  }
  angles = std::move(settled);
  return kept;
}

std::vector<float> kept_columns(const std::vector<float>& values, std::size_t columns,
                                const std::vector<std::size_t>& kept) {
  std::vector<float> out;
  for (std::size_t row = 0; row < values.size(); row += columns)
    for (const std::size_t column : kept) out.push_back(values[row + column]);
  return out;
}

}  // namespace glowworm
