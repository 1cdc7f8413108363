#include "core/lines.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace glowworm {
namespace {

TEST(Lines, EndsOfAllSystems) {
  std::string_view text = "a\nb\r\nc\rd\n\ne";
  std::vector<std::string> lines;
  while (!text.empty()) lines.emplace_back(take_line(text));
  EXPECT_EQ(lines, (std::vector<std::string>{"a", "b", "c", "d", "", "e"}));
  EXPECT_EQ(without_byte_order_mark("\xef\xbb\xbf"
                                    "a"),
            "a");
  EXPECT_EQ(without_byte_order_mark("a\xef\xbb\xbf"), "a\xef\xbb\xbf");
}

TEST(Lines, NumbersOfAllSpellings) {
  const auto number = [](std::string_view text) {
    double value = -7;
    EXPECT_TRUE(take_number(text, value)) << text;
    EXPECT_EQ(text, "|");
    return value;
  };
  EXPECT_EQ(number("+1.5|"), 1.5);
  EXPECT_EQ(number(".5e1|"), 5);
  EXPECT_EQ(number("-1e999|"), -INFINITY);
  EXPECT_EQ(number("1e-999|"), 0);
  EXPECT_EQ(number(std::string(400, '9') + "|"), INFINITY);
  EXPECT_EQ(number("-0." + std::string(400, '0') + "1|"), 0);
  EXPECT_EQ(number("1.#INF|"), INFINITY);
  EXPECT_EQ(number("-1.#INF00|"), -INFINITY);
  for (const char* text : {"1.#QNAN|", "-1.#IND0|", "1.#SNAN|", "nan|"}) EXPECT_TRUE(std::isnan(number(text))) << text;
  for (std::string_view text : {"", "x", "+-1", "#QNAN", "+"}) {
    double value = -7;
    EXPECT_FALSE(take_number(text, value)) << text;
    EXPECT_EQ(value, -7);
  }
}

}  // namespace
}  // namespace glowworm
