// The tokens of a pbrt scene file: words, numbers, strings, brackets.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "import/pbrt/diagnostics.h"

namespace glowworm {

enum class PbrtTokenKind : std::uint8_t { word, number, string, left_bracket, right_bracket, end };

/// One token. `text` points into the file's text: a string's without its quotes, escapes not resolved.
struct PbrtToken {
  PbrtTokenKind kind = PbrtTokenKind::end;
  std::string_view text;
  PbrtPlace place;
  double number = 0;         ///< number: its value
  bool has_escapes = false;  ///< string: there is a backslash in it
};

/// Cuts a text into tokens. White space and comments (# to the end of the line) part them. What is no token (an
/// unterminated string, a malformed number, a NUL or control byte) is recorded as an error and skipped.
class PbrtTokenizer {
 public:
  /// `text` must outlive the tokenizer and its tokens.
  PbrtTokenizer(std::string_view text, const std::string* file, PbrtDiagnostics& diagnostics);
  /// Takes the next token; kind `end` at the end of the text, again and again.
  PbrtToken next();
  /// The next token, not taken.
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

/// The characters that a string token stands for: \n \t \r \b \f \\ \" \' resolved, others left as they are.
std::string unescape(const PbrtToken& token);

}  // namespace glowworm
