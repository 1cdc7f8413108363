#include "density/engine_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "density/density_scenes.h"

namespace glowworm::density_tests {
namespace {

TEST(EngineChoice, KnowsEnginesThatTakeTheRadiiOfPhotons) {
  const PhotonBatch photons = room_photons(100);
  RadiusPolicy policy;
  policy.radii.assign(photons.size(), 0.1f);
  ASSERT_FALSE(engine_costs().empty());
  for (const EngineCosts& costs : engine_costs()) {
    Statistics statistics;
    EXPECT_NO_THROW(make_engine(costs.engine)->build(photons, policy, statistics)) << costs.engine;
    for (const double build : costs.build) EXPECT_GT(build, 0) << costs.engine;
    EXPECT_GT(costs.query, 0) << costs.engine;
  }
}

TEST(EngineChoice, CostsGrowWithEverythingThatIsAskedFor) {
  const EngineWorkload base{1e5, 1e6, 1e6, 50};
  for (const EngineCosts& costs : engine_costs()) {
    const double seconds = expected_seconds(costs, base);
    EXPECT_GT(seconds, 0);
    EXPECT_GT(expected_seconds(costs, {2e5, 1e6, 1e6, 50}), seconds) << costs.engine;
    EXPECT_GT(expected_seconds(costs, {1e5, 2e6, 1e6, 50}), seconds) << costs.engine;
    EXPECT_GT(expected_seconds(costs, {1e5, 1e6, 1e6, 100}), seconds) << costs.engine;
    // The same points in smaller portions lie farther apart, which is nothing to an engine that takes them one by one.
    if (std::string(costs.engine) == "single")
      EXPECT_EQ(expected_seconds(costs, {1e5, 1e6, 1e4, 50}), seconds);
    else
      EXPECT_GT(expected_seconds(costs, {1e5, 1e6, 1e4, 50}), seconds) << costs.engine;
  }
}

TEST(EngineChoice, TakesTheEngineOfLeastCostOrBlockedWhereThatIsAsGood) {
  int others = 0;
  for (const double photons : {1e3, 1e5, 1e6, 1e7})
    for (const double queries : {1e2, 1e3, 1e4, 1e6, 1e8}) {
      const EngineWorkload workload{photons, queries, std::min(queries, 4e6), 50};
      double least = 1e30, chosen = 0;
      for (const EngineCosts& costs : engine_costs()) {
        const double seconds = expected_seconds(costs, workload);
        least = std::min(least, seconds);
        if (choose_engine(workload) == costs.engine) chosen = seconds;
      }
      if (choose_engine(workload) == "blocked") {
        EXPECT_LE(0.9 * chosen, least);
      } else {
        EXPECT_EQ(chosen, least);
        ++others;
      }
    }
  EXPECT_GT(others, 0);
}

TEST(EngineChoice, BuildsBlocksWhereManyPointsAreLookedUp) {
  EXPECT_EQ(choose_engine({5e5, 1e8, 4e6, 50}), "blocked");
  EXPECT_NE(choose_engine({1e6, 1e3, 1e3, 50}), "blocked");
}

TEST(EngineChoice, LooksFewPointsUpOneByOne) { EXPECT_EQ(choose_engine({1e6, 1e3, 1e3, 50}), "single"); }

TEST(EngineChoice, BearsNothingAndTheBoundless) {
  EXPECT_FALSE(choose_engine({0, 0, 0, 0}).empty());
  EXPECT_FALSE(choose_engine({1e300, 1e300, 1e300, 1e300}).empty());
}

}  // namespace
}  // namespace glowworm::density_tests
