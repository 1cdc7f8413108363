#include "density/engine.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "density/density_scenes.h"
#include "kernels/simd.h"

namespace glowworm::density_tests {
namespace {

TEST(EngineTraits, MatchTheEngine) {
  for (const std::string& name : engine_names()) {
    EXPECT_EQ(engine_traits(name).name, name);
    EXPECT_EQ(make_engine(name)->name(), name);
    EXPECT_GE(engine_traits(name).lanes(), simd_lanes());
  }
}

TEST(EngineTraits, AutoIsAnEngineForPicturesThatTakesTheRadiiOfPhotons) {
  const EngineTraits& traits = engine_traits("auto");
  EXPECT_STREQ(traits.name, kAutomaticEngine);
  EXPECT_FALSE(traits.for_tests);
  EXPECT_FALSE(traits.takes_nearest);
  EXPECT_EQ(make_engine("auto")->name(), kAutomaticEngine);
}

TEST(EngineTraits, TakesNearestIsTrueForEnginesThatAcceptItInPlaceOfRadii) {
  const PhotonBatch photons = room_photons(100);
  RadiusPolicy policy;
  policy.kind = RadiusKind::nearest;
  policy.k = 5;
  RadiusPolicy own;
  own.radii.assign(100, 0.1f);
  int taken = 0;
  for (const std::string& name : engine_names()) {
    if (!engine_traits(name).takes_nearest) continue;
    Statistics statistics;
    EXPECT_NO_THROW(make_engine(name)->build(photons, photons.flux, policy, statistics)) << name;
    EXPECT_THROW(make_engine(name)->build(photons, photons.flux, own, statistics), Error) << name;
    ++taken;
  }
  EXPECT_GT(taken, 0);
}

TEST(EngineTraits, UnknownNameListsTheEngines) {
  try {
    engine_traits("quick");
    FAIL() << "did not throw";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("there is no density engine \"quick\""), std::string::npos);
  }
  EXPECT_THROW(make_engine("quick"), Error);
}

}  // namespace
}  // namespace glowworm::density_tests
