#include "core/text.h"

#include <gtest/gtest.h>

namespace glowworm {
namespace {

TEST(Printable, LeavesTextAndEscapesWhatCommandsATerminal) {
  const std::string plain = "a\tb\nGr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x92\xa1";
  EXPECT_EQ(printable(plain), plain);
  EXPECT_EQ(printable("\x1b]0;title\x07\r\x7f"), "\\x1b]0;title\\x07\\x0d\\x7f");
  EXPECT_EQ(printable("a\xc2\x9b"
                      "31m"),
            "a\\u009b31m");  // the same command in one character
  EXPECT_EQ(printable("a\xe2\x80\xae"
                      "b"),
            "a\\u202eb");                                                     // right to left
  EXPECT_EQ(printable("\x9b\xff\xc3"), "\\x9b\\xff\\xc3");                    // not UTF-8
  EXPECT_EQ(printable("\xc0\x9b\xe0\x80\x9b"), "\\xc0\\x9b\\xe0\\x80\\x9b");  // longer than needed
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
}

TEST(ShellWord, IsQuotedWhereAShellWouldChangeIt) {
  EXPECT_EQ(shell_word("room/a-1.exr"), "room/a-1.exr");
  EXPECT_EQ(shell_word("--size=4x4"), "--size=4x4");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(shell_word("it's; rm -r x"), "'it'\\''s; rm -r x'");
}

}  // namespace
}  // namespace glowworm
