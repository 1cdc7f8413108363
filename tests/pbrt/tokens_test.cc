#include "import/pbrt/tokens.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.h"

namespace glowworm {
namespace {

struct Scanned {
  std::vector<PbrtToken> tokens;
  std::string error;
};

/// All tokens of a text, which must outlive them.
Scanned scan(std::string_view text) {
  static const std::string file = "f.pbrt";
  PbrtDiagnostics diagnostics;
  PbrtTokenizer tokenizer(text, &file, diagnostics);
  Scanned out;
  for (PbrtToken token = tokenizer.next(); token.kind != PbrtTokenKind::end; token = tokenizer.next()) {
    out.tokens.push_back(token);
  }
  try {
    diagnostics.throw_if_errors();
  } catch (const Error& error) {
    out.error = error.what();
  }
  return out;
}

TEST(PbrtTokens, KindsAndPlaces) {
  const auto [tokens, error] = scan("Shape \"sphere\" # a comment [\n\t\"float radius\" [ 2.5e-1 ]-3");
  EXPECT_EQ(error, "");
  ASSERT_EQ(tokens.size(), 7u);
  using enum PbrtTokenKind;
  const PbrtTokenKind kinds[] = {word, string, string, left_bracket, number, right_bracket, number};
  const char* texts[] = {"Shape", "sphere", "float radius", "[", "2.5e-1", "]", "-3"};
  const int lines[] = {1, 1, 2, 2, 2, 2, 2}, columns[] = {1, 7, 2, 17, 19, 26, 27};
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    EXPECT_EQ(tokens[i].kind, kinds[i]) << i;
    EXPECT_EQ(tokens[i].text, texts[i]);
    EXPECT_EQ(tokens[i].place.line, lines[i]) << i;
    EXPECT_EQ(tokens[i].place.column, columns[i]) << i;
  }
  EXPECT_EQ(tokens[4].number, 0.25);
  EXPECT_EQ(tokens[6].number, -3);
}

TEST(PbrtTokens, NumbersInAllSpellings) {
  const auto [tokens, error] = scan("1 +1 .5 5. -0.25 1e3 1E-3 1e-400");
  EXPECT_EQ(error, "");
  const double values[] = {1, 1, 0.5, 5, -0.25, 1000, 0.001, 0};
  ASSERT_EQ(tokens.size(), 8u);
  for (std::size_t i = 0; i < tokens.size(); ++i) EXPECT_EQ(tokens[i].number, values[i]) << i;
}

TEST(PbrtTokens, WordsOfOtherFormatsAreNoNumbers) {
  for (const char* text : {"1e400", "-inf", "+nan", "1.2.3", "0x10", "--1", "-", ".", "1.#QNAN", "1#2"}) {
    EXPECT_NE(scan(text).error.find("is not a number"), std::string::npos) << text;
  }
}

TEST(PbrtTokens, Escapes) {
  const auto [tokens, error] = scan(R"("a\"b\\c\n" "plain")");
  EXPECT_EQ(error, "");
  ASSERT_EQ(tokens.size(), 2u);
  EXPECT_EQ(unescape(tokens[0]), "a\"b\\c\n");
  EXPECT_EQ(unescape(tokens[1]), "plain");
}

TEST(PbrtTokens, UnterminatedStringIsAnErrorAtItsBeginning) {
  const auto [tokens, error] = scan("Shape \"sphere\n  Material");
  EXPECT_EQ(error, "f.pbrt:1:7: the string \"sphere\" has no end\n  Close it with a double quote on the same line.");
  ASSERT_EQ(tokens.size(), 2u);
  EXPECT_EQ(tokens[1].text, "Material");
}

TEST(PbrtTokens, NulInStringIsAnError) {
  const auto [tokens, error] = scan(std::string_view("\"a\0b\" Next", 10));
  EXPECT_NE(error.find("f.pbrt:1:1: the string \"a\\x00b\" holds a NUL byte"), std::string::npos) << error;
  ASSERT_EQ(tokens.size(), 1u);
}

TEST(PbrtTokens, ByteOrderMarkAndCarriageReturnsAreBlank) {
  const auto [tokens, error] = scan("\xef\xbb\xbfWorldBegin\r\nIdentity\r\n");
  EXPECT_EQ(error, "");
  ASSERT_EQ(tokens.size(), 2u);
  EXPECT_EQ(tokens[0].place.column, 1);
  EXPECT_EQ(tokens[1].text, "Identity");
  EXPECT_EQ(tokens[1].place.line, 2);
}

TEST(PbrtTokens, LinesMayEndInCarriageReturnsAlone) {
  const auto [tokens, error] = scan("# a comment\rWorldBegin # another\rIdentity");
  EXPECT_EQ(error, "");
  ASSERT_EQ(tokens.size(), 2u);
  EXPECT_EQ(tokens[0].text, "WorldBegin");
  EXPECT_EQ(tokens[0].place.line, 2);
  EXPECT_EQ(tokens[1].place.line, 3);
}

TEST(PbrtTokens, PeekTakesNothing) {
  PbrtDiagnostics diagnostics;
  PbrtTokenizer tokenizer("a b", nullptr, diagnostics);
  EXPECT_EQ(tokenizer.peek().text, "a");
  EXPECT_EQ(tokenizer.peek().text, "a");
  EXPECT_EQ(tokenizer.next().text, "a");
  EXPECT_EQ(tokenizer.next().text, "b");
  EXPECT_EQ(tokenizer.next().kind, PbrtTokenKind::end);
  EXPECT_EQ(tokenizer.next().kind, PbrtTokenKind::end);
}

}  // namespace
}  // namespace glowworm
