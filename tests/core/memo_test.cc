#include "core/memo.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace glowworm {
namespace {

struct Early {
  int seed = 0;
  bool operator==(const Early&) const = default;
};
struct Late : Early {
  float scale = 1;
  bool operator==(const Late&) const = default;
};

TEST(Memo, MakesItsValueAgainOnlyWhereInputsDiffer) {
  Memo<Late, int> stage;
  int made = 0;
  const auto make = [&] { return ++made; };
  Late inputs;
  EXPECT_FALSE(stage.is_made_of(inputs));
  EXPECT_EQ(stage.inputs(), nullptr);
  EXPECT_EQ(stage.update(inputs, make), 1);
  EXPECT_EQ(stage.update(inputs, make), 1);
  inputs.scale = 2;
  EXPECT_EQ(stage.update(inputs, make), 2);
  inputs.seed = 1;  // an input of an earlier stage
  EXPECT_EQ(stage.update(inputs, make), 3);
  stage.keep_if(inputs);
  EXPECT_EQ(*stage, 3);
  stage.keep_if(Late());
  EXPECT_EQ(*stage, 0);
  EXPECT_EQ(stage.update(inputs, make), 4);
}

TEST(Memo, HasNoValueWhereMakingItFails) {
  Memo<Early, int> stage;
  stage.update({1}, [] { return 7; });
  EXPECT_THROW(stage.update({2}, []() -> int { throw std::runtime_error("interrupted"); }), std::runtime_error);
  EXPECT_FALSE(stage.is_made_of({1}));
  EXPECT_FALSE(stage.is_made_of({2}));
  EXPECT_EQ(*stage, 0);
}

}  // namespace
}  // namespace glowworm
