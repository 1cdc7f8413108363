#include "kernels/simd.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"

namespace glowworm {
namespace {

TEST(Simd, EveryInstructionSetCanBeChosen) {
  const std::vector<std::string> names = simd_names();
  ASSERT_FALSE(names.empty());
  for (const std::string& name : names) {
    set_simd(name);
    EXPECT_EQ(simd_name(), name);
    EXPECT_GE(simd_lanes(), 1);
    if (name == "avx2") {
      EXPECT_EQ(simd_lanes(), 8);
    }
    if (name == "avx512") {
      EXPECT_EQ(simd_lanes(), 16);
    }
    if (name == "sse4") {
      EXPECT_EQ(simd_lanes(), 4);
    }
    EXPECT_EQ(simd_names(), names);
  }
  set_simd("auto");
  EXPECT_EQ(simd_name(), names.front());
  EXPECT_NE(std::find(names.begin(), names.end(), "scalar"), names.end());
}

TEST(Simd, RejectsUnknownInstructionSets) {
  EXPECT_THROW(set_simd("mmx"), Error);
  EXPECT_EQ(simd_name(), simd_names().front());
}

}  // namespace
}  // namespace glowworm
