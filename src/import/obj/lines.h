// The lines and words of OBJ and MTL files.
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace glowworm {

/// Gives the logical lines of a text, in time that is linear in its length: a backslash at the end joins two lines, and
/// what follows a '#' at the beginning of a word is left out.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {}
  /// Moves to the next line; false after the last.
  bool next();
  /// The line, valid until next().
  std::string_view line() const { return line_; }
  /// Its number, or that of the last that was joined to it; from 1.
  int number() const { return number_; }

 private:
  std::string_view take_physical_line();

  std::string_view rest_, line_;
  std::string joined_;
  int number_ = 0;
};

/// Takes the next word off the front of `rest`; empty at the end of the line.
std::string_view next_word(std::string_view& rest);

/// The text without the blanks around it: names of files and materials may hold spaces.
std::string_view trimmed(std::string_view text);

/// The number that a word is; infinite beyond the range of float; nothing where it is no number.
std::optional<float> number_of(std::string_view word);

}  // namespace glowworm
