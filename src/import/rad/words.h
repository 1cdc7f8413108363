// Words and numbers of Radiance's scene files.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace glowworm {

/// A description of a scene file: "modifier type name", its words and its numbers.
struct RadPrimitive {
  std::string modifier, type, name;
  std::string alias_of;  ///< of type "alias": the name of what it stands for
  std::vector<std::string> words;
  std::vector<double> numbers;  ///< finite
  FilePlace place;
};

/// Reads a text item by item. What it returns lives as long as the text.
class RadWords {
 public:
  /// @param place of its first line
  RadWords(std::string_view text, FilePlace place);

  enum class Item { none, command, primitive };
  /// Skips blanks, and comments between primitives, up to the next item.
  Item next();
  /// The command of a line that begins with '!', without it. Lines that end in a backslash continue.
  std::string command();
  /// Throws Error with file and line where words are missing or are no numbers.
  RadPrimitive primitive();
  /// The line of the last word.
  const FilePlace& place() const { return place_; }

 private:
  std::string word(std::string_view wanted);
  std::size_t count(std::string_view what);
  void skip_blanks();
  char take();

  std::string_view rest_;
  FilePlace place_;
};

/// The stages of a pipeline, each a command with its arguments; words may be quoted. Throws Error for anything else
/// that a shell would act on.
std::vector<std::vector<std::string>> rad_pipeline(const std::string& command, const FilePlace& place);

/// A number that is the whole word and finite as a float; empty for other words.
std::optional<double> rad_number(std::string_view word);
/// The same. Throws Error that names what it is, for other words.
double rad_number(std::string_view word, std::string_view what, const FilePlace& place);
/// A whole number that is not negative. Throws Error that names what it is, for other words.
std::size_t rad_count(std::string_view word, std::string_view what, const FilePlace& place);

}  // namespace glowworm
