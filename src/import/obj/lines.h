// Lines and words of OBJ, MTL and ASCII STL files.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "core/lines.h"

namespace glowworm {

/// Iterates over the logical lines of a text, in linear time. A backslash at the end of a line joins it to the next. A
/// word that starts with '#' begins a comment, which is skipped.
class LineReader {
 public:
  explicit LineReader(std::string_view text);
  /// Moves to the next line. Returns false at the end.
  bool next();
  /// The line, valid until next().
  std::string_view line() const { return line_; }
  /// Number of the line, or of the last line joined to it, from 1.
  int number() const { return number_; }

 private:
  std::string_view take_physical_line();

  std::string_view rest_, line_;
  std::string joined_;
  int number_ = 0;
};

/// As take_word(), but a word in double quotes may contain blanks; it is returned without the quotes.
std::string_view next_name(std::string_view& rest);

/// The text without surrounding blanks and without double quotes around it: names of files and materials may contain
/// spaces.
std::string_view name_of(std::string_view text);

/// Parses a number as take_number() does; empty if the word is not one. Beyond float's range, a float is infinite.
std::optional<double> number_of(std::string_view word);
std::optional<float> float_of(std::string_view word);

}  // namespace glowworm
