// Matrices in Radiance's formats.
#include "measure/matrix_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/error.h"

namespace glowworm {
namespace {

TEST(MatrixFile, ComesBackAsItWasWritten) {
  ColorMatrix m{2, 3, {}};
  for (int i = 0; i < 6; ++i) m.value.emplace_back(static_cast<float>(i), 0.5f, 1e-7f);
  const ColorMatrix back = parse_matrix(matrix_text(m, "NROWS of words"), "a.mtx");
  ASSERT_EQ(back.rows, 2u);
  ASSERT_EQ(back.columns, 3u);
  EXPECT_EQ(back.at(1, 2).r, 5);
  EXPECT_NEAR(back.at(0, 1).b, 1e-7f, 1e-13);
}

TEST(MatrixFile, ReadsTheFormatsOfRadiance) {
  const std::string head = "#?RADIANCE\ngendaymtx -s a.wea\nLATLONG= 48 -11\nNROWS=1\nNCOLS=2\nNCOMP=";
  // gendaymtx writes an element a line, and an empty line after each row.
  const ColorMatrix text = parse_matrix(head + "3\nFORMAT=ascii\n\n1 2 3\n4 5 6e-1\n\n", "a.smx");
  EXPECT_EQ(text.at(0, 1).b, 0.6f);
  EXPECT_EQ(parse_matrix(head + "1\nFORMAT=ascii\n\n7 8\n", "a.smx").at(0, 1).g, 8);
  const auto binary = [](const auto& values, bool swapped) {
    std::string out;
    for (const auto v : values) {
      std::string bytes(sizeof(v), ' ');
      std::memcpy(bytes.data(), &v, sizeof(v));
      out += swapped ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
    }
    return out;
  };
  const float singles[6] = {1, 2, 3, 4, 5, 6};
  const double doubles[6] = {1, 2, 3, 4, 5, 6};
  for (const bool swapped : {false, true}) {
    const std::string end = swapped ? "BigEndian=1\n\n" : "BigEndian=0\n\n";
    EXPECT_EQ(parse_matrix(head + "3\nFORMAT=float\n" + end + binary(singles, swapped), "a.smx").at(0, 1).b, 6);
    EXPECT_EQ(parse_matrix(head + "3\nFORMAT=double\n" + end + binary(doubles, swapped), "a.smx").at(0, 1).g, 5);
  }
}

TEST(MatrixFile, RefusesOthers) {
  for (const char* bad :
       {"", "1 2 3\n", "#?RADIANCE\nNROWS=1\nNCOLS=1\nFORMAT=ascii\n\n1 2\n",
        "#?RADIANCE\nNROWS=1\nNCOLS=1\nNCOMP=2\nFORMAT=ascii\n\n1 2\n",
        "#?RADIANCE\nNROWS=1e9\nNCOLS=1e9\nFORMAT=ascii\n\n1 2 3\n",
        "#?RADIANCE\nNROWS=1\nNCOLS=1\nFORMAT=ascii\n\n1 nan 3\n",
        "#?RADIANCE\nNROWS=1\nNCOLS=1\nFORMAT=rle\n\n1 2 3\n", "#?RADIANCE\nNROWS=1\nNCOLS=x\nFORMAT=ascii\n\n1 2 3\n"})
    EXPECT_THROW(parse_matrix(bad, "a.mtx"), Error) << bad;
}

}  // namespace
}  // namespace glowworm
