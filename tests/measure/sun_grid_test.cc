// Places of the sun that others are interpolated between.
#include "measure/sun_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "import/daylight.h"
#include "scene/sky_model.h"

namespace glowworm {
namespace {

/// Suns of a day each month, every twenty minutes.
std::vector<Vec3> suns_at(double latitude) {
  std::vector<Vec3> out;
  for (int month = 1; month <= 12; ++month)
    for (int i = 0; i < 72; ++i) {
      const SunPlace sun = sun_place({month, 21, i / 3.0, latitude, 0, 0});
      if (sun.altitude > 0)
        out.push_back(sky_direction(static_cast<float>(sun.altitude), static_cast<float>(sun.azimuth)));
    }
  return out;
}

TEST(SunGrid, SurroundsEverySun) {
  constexpr double kStep = 10;
  for (const double latitude : {48.0, 0.0, -33.0, 78.0, 90.0}) {
    const std::vector<Vec3> suns = suns_at(latitude);
    const SunGrid grid({.latitude = latitude}, suns, std::vector<float>(suns.size(), 1.0f), kStep);
    ASSERT_EQ(grid.shares().size(), suns.size());
    EXPECT_LT(grid.places().size(), 250u) << latitude;
    for (std::size_t i = 0; i < suns.size(); ++i) {
      double sum = 0;
      Vec3 mean{0, 0, 0};
      for (const SunGrid::Share& share : grid.shares()[i]) {
        if (!(share.weight > 0)) continue;
        ASSERT_LT(share.place, grid.places().size());
        const Vec3 place = grid.places()[share.place];
        EXPECT_GT(place.y, 0) << "above the horizon";
        EXPECT_GT(dot(place, suns[i]), std::cos(1.5 * kStep * M_PI / 180)) << latitude;
        sum += share.weight;
        mean += place * share.weight;
      }
      EXPECT_NEAR(sum, 1, 1e-5);
      // Places that are not raised to the horizon interpolate the direction, but for the curve of the sphere.
      const bool high = suns[i].y > std::sin(1.5 * kStep * M_PI / 180);
      if (high) {
        EXPECT_GT(dot(normalize(mean), suns[i]), std::cos(0.01)) << latitude << ' ' << i;
      }
    }
  }
}

TEST(SunGrid, HasNoPlacesForSunsThatDoNotShine) {
  const std::vector<Vec3> suns = {sky_direction(30, 180), sky_direction(5, 90)};
  const SunGrid grid({.latitude = 48}, suns, std::vector<float>{1, 0}, 5);
  EXPECT_LE(grid.places().size(), 4u);
  for (const SunGrid::Share& share : grid.shares()[1]) EXPECT_EQ(share.weight, 0);
  EXPECT_TRUE(SunGrid({.latitude = 48}, {}, {}, 5).places().empty());
}

}  // namespace
}  // namespace glowworm
