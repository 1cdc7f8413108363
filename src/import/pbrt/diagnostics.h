// What is wrong with, or not supported in, a pbrt scene: collected while it is read, told at the end.
#pragma once
#include <cstddef>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace glowworm {

/// A place in one of the files of a scene; the file's name is kept by PbrtDiagnostics.
struct PbrtPlace {
  const std::string* file = nullptr;
  int line = 0, column = 0;  ///< from 1; 0 is not known
};

/// A name from a file for use in a message: in double quotes, cut after 60 bytes, what cannot be printed as \xNN.
std::string in_quotes(std::string_view name);

/// Collects errors and notes. Reading goes on after an error, so that one run finds several.
class PbrtDiagnostics {
 public:
  /// After this many errors reading stops.
  static constexpr std::size_t kMaxErrors = 20;

  /// Keeps a file's name for places to point to.
  const std::string* add_file(std::string name);

  /// Records a mistake that makes the scene unusable: what is wrong and what can be done. Errors beyond kMaxErrors are
  /// dropped.
  void error(const PbrtPlace& place, const std::string& message, const std::string& remedy);
  std::size_t error_count() const { return errors_.size(); }
  /// True when there are so many errors that reading should stop.
  bool full() const { return errors_.size() >= kMaxErrors; }
  /// Throws one Error that lists all errors, if there are any.
  void throw_if_errors() const;

  /// Records something that is left out or guessed; the same text is counted, with its first place.
  void note(const PbrtPlace& place, const std::string& text, std::size_t times = 1);
  /// One line a note: "text (file:line:column, and 3 more)", in order of first appearance.
  std::vector<std::string> notes() const;

 private:
  struct Note {
    std::string text;
    PbrtPlace first;
    std::size_t count = 0;
  };
  std::deque<std::string> files_;
  std::vector<std::string> errors_;
  std::vector<Note> notes_;
  std::map<std::string, std::size_t, std::less<>> note_index_;
};

/// "file:line:column".
std::string to_string(const PbrtPlace& place);

}  // namespace glowworm
