// Errors and notes on a pbrt scene, collected while reading and reported at the end.
#pragma once
#include <cstddef>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace glowworm {

/// A place in one of the files of a scene. PbrtDiagnostics stores the file's name.
struct PbrtPlace {
  const std::string* file = nullptr;
  int line = 0, column = 0;  ///< from 1; 0: unknown
};

/// Formats a name from a file for messages: in double quotes, truncated to 60 bytes, with unprintable characters as
/// \xNN.
std::string in_quotes(std::string_view name);

/// Collects errors and notes. Reading continues after an error, so that one run finds several.
class PbrtDiagnostics {
 public:
  /// Reading stops after this many errors.
  static constexpr std::size_t kMaxErrors = 20;

  /// Stores a file's name, to which places can point.
  const std::string* add_file(std::string name);

  /// Records an error that makes the scene unusable, with its remedy. Errors beyond kMaxErrors are dropped.
  void error(const PbrtPlace& place, const std::string& message, const std::string& remedy);
  std::size_t error_count() const { return errors_.size(); }
  /// Whether there are so many errors that reading should stop.
  bool full() const { return errors_.size() >= kMaxErrors; }
  /// Throws one Error that lists all errors, if there are any.
  void throw_if_errors() const;

  /// Records a feature that is left out or guessed. Equal texts are counted, with the first place.
  void note(const PbrtPlace& place, const std::string& text, std::size_t times = 1);
  /// One line per note, "text (file:line:column, and 3 more)", in order of first appearance.
  std::vector<std::string> notes() const;

 private:
  struct Problem {
    FilePlace place;
    std::string text;  ///< message and remedy
  };
  struct Note {
    std::string text;
    PbrtPlace first;
    std::size_t count = 0;
  };
  std::deque<std::string> files_;
  std::vector<Problem> errors_;
  std::vector<Note> notes_;
  std::map<std::string, std::size_t, std::less<>> note_index_;
};

/// "file:line:column".
std::string to_string(const PbrtPlace& place);

}  // namespace glowworm
