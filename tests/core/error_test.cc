#include "core/error.h"

#include <gtest/gtest.h>

#include "core/option_names.h"

namespace glowworm {
namespace {

TEST(Error, NamesOptionsAsTheProgramOrTheLibraryDoes) {
  const auto text = [] {
    return std::string(Error({"a--b.obj"}, "--gather '--x' -- is (--no-filter)", "Give --memory 1G.").what());
  };
  EXPECT_EQ(text(), "a--b.obj: --gather '--x' -- is (--no-filter)\n  Give --memory 1G.");
  name_options_with_dashes(false);
  EXPECT_EQ(text(), "a--b.obj: gather 'x' -- is (no-filter)\n  Give memory 1G.");
  name_options_with_dashes(true);
}

}  // namespace
}  // namespace glowworm
