// The lines and numbers of photometric files.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace glowworm {

/// Takes lines and numbers from a text, without its UTF-8 byte order mark, and tells places in errors.
class PhotometricText {
 public:
  PhotometricText(std::string_view text, std::string path);

  /// The rest of the current line, without its end, which the last line need not have. Throws Error behind the last.
  std::string_view line(const char* what);
  /// The next number, on this line or a later one; blanks and commas stand between numbers. Throws Error for what is no
  /// finite number, and where the text ends before it.
  float number(const char* what);
  /// The number that is alone on the next line; a comma may be its decimal point.
  float number_line(const char* what);
  /// Skips that many lines, each blank or with a number that is alone on it. Throws Error for others.
  void skip_number_lines(const char* what, std::size_t count) { optional_number_lines(what, count); }
  /// The numbers of that many lines, 0 where one is blank. Throws Error for others.
  std::vector<float> optional_number_lines(const char* what, std::size_t count);
  /// A whole number of [least, most], by number() or number_line().
  int count(const char* what, float value, int least, int most) const;
  /// That many numbers. Throws Error where the text is too short for them.
  std::vector<float> numbers(const char* what, std::size_t count);
  std::vector<float> number_lines(const char* what, std::size_t count);
  /// Throws Error if another number follows. @param what the numbers that were read last
  void check_end(const char* what);
  /// Throws Error where the text cannot hold that many more numbers.
  void check_room(const char* what, std::size_t count) const;

  [[noreturn]] void fail(const std::string& message) const;
  [[noreturn]] void fail_at_end(const char* what) const;
  const std::string& path() const { return path_; }

 private:
  void skip_blanks();
  float value_of(std::string_view word, const char* what) const;
  /// As number_line(); nothing where the line is blank and may be.
  std::optional<float> number_or_blank(const char* what, bool may_be_blank);

  std::string_view text_;
  std::string path_;
  std::size_t place_ = 0;
  int line_ = 1;
};

/// Degrees by which rounding may move the angles of a file.
constexpr float kAngleRounding = 0.01f;

/// Puts angles (ascending, degrees) that rounding has moved beyond [least, most] onto its ends, and the first and the
/// last one onto a multiple of 90 degrees beside it. Returns the indices of the angles; those that now repeat another
/// are gone from both.
std::vector<std::size_t> settle_angles(std::vector<float>& angles, float least, float most);

/// Rows of the kept columns alone. @param columns of each row in `values`
std::vector<float> kept_columns(const std::vector<float>& values, std::size_t columns,
                                const std::vector<std::size_t>& kept);

}  // namespace glowworm
