// The tokens of a pbrt scene file: words, numbers, strings, brackets.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "import/pbrt/diagnostics.h"

namespace glowworm {

enum class PbrtTokenKind : std::uint8_t { word, number, string, left_bracket, right_bracket, end };

/// One token. `text` points into the file's text. A string's text excludes the quotes, and its escapes are not
/// resolved.
struct PbrtToken {
  PbrtTokenKind kind = PbrtTokenKind::end;
  std::string_view text;
  PbrtPlace place;
  double number = 0;         ///< value of a number
  bool has_escapes = false;  ///< whether a string contains a backslash
};

/// Splits a text into tokens, separated by white space and comments (# to the end of the line). Anything else (an
/// unterminated string, a malformed number, a NUL or control byte) is recorded as an error and skipped.
class PbrtTokenizer {
 public:
  /// `text` must outlive the tokenizer and its tokens.
  PbrtTokenizer(std::string_view text, const std::string* file, PbrtDiagnostics& diagnostics);
  /// Takes the next token. At the end of the text, always returns kind `end`.
  PbrtToken next();
  /// The next token, without taking it.
  const PbrtToken& peek();

 private:
  void skip_blanks();
  PbrtPlace place() const;
  PbrtToken scan();
  bool scan_string(PbrtToken& token);
  bool scan_word(PbrtToken& token);

  std::string_view text_;
  std::size_t at_ = 0, line_start_ = 0;
  int line_ = 1;
  const std::string* file_;
  PbrtDiagnostics& diagnostics_;
  PbrtToken peeked_;
  bool has_peeked_ = false;
};

/// The text of a string token, with \n \t \r \b \f \\ \" \' resolved and other characters unchanged.
std::string unescape(const PbrtToken& token);

}  // namespace glowworm
