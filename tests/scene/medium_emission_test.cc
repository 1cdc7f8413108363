#include "scene/medium_emission.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/warp.h"

namespace glowworm {
namespace {

/// A grid in which density and emission overlap between cells only.
Medium apart() {
  MediumGridValues values;
  values.size = {6, 5, 4};
  values.density.assign(values.cell_count(), 0.0f);
  values.emission.assign(values.cell_count(), RGB(0.0f));
  const auto cell = [](int x, int y, int z) { return static_cast<std::size_t>((z * 5 + y) * 6 + x); };
  values.density[cell(2, 2, 1)] = 3;
  values.emission[cell(3, 2, 2)] = RGB(1, 2, 4);
  values.density[cell(5, 4, 3)] = 1;
  values.emission[cell(5, 4, 3)] = RGB(2, 1, 0);
  Medium medium;
  medium.sigma_a = RGB(0.5f, 1, 2);
  medium.emission = RGB(10.0f);
  medium.bounds = Box3{{-1, 0, 2}, {2, 1, 4}};
  medium.to_medium = {{2, 0, 0}, {0.5f, 1, 0}, {0, 0, 0.5f}, {1, 2, 3}};
  medium.grid = std::make_shared<const MediumGrid>(std::move(values));
  return medium;
}

/// The flux of the medium, by a sum over small cubes of its own space.
RGB flux_by_cubes(const Medium& medium) {
  constexpr int kSide = 120;
  const Transform to_scene = inverse(medium.to_medium);
  const Vec3 size = medium.bounds->diagonal();
  RGB sum;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const auto at = [](int n) { return (static_cast<float>(n % kSide) + 0.5f) / kSide; };
    const Vec3 u{at(i), at(i / kSide), at(i / kSide / kSide)};
    sum += medium_point(medium, to_scene.point(medium.bounds->min + Vec3{u.x * size.x, u.y * size.y, u.z * size.z}))
               .emission;
  }
  const float volume = size.x * size.y * size.z / std::abs(medium.to_medium.determinant());
  return sum * (4 * kPi * volume / (kSide * kSide * kSide));
}

TEST(MediumEmission, PhotonsCarryTheFluxOfTheGrid) {
  const Medium medium = apart();
  const MediumEmission emission(0, medium, Box3(), false);
  const RGB right = flux_by_cubes(medium);
  constexpr int kPhotons = 200'000;
  RGB sum;
  for (int i = 0; i < kPhotons; ++i) {
    // Evenly spread points (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
    const auto part = [i](double step) { return static_cast<float>(std::fmod(0.5 + i * step, 1.0)) * 0.999999f; };
    const MediumEmission::Start start =
        emission.sample(medium, {part(0.8191725133961645), part(0.6710436067037893), part(0.5497004779019703)});
    EXPECT_TRUE(medium.bounds->contains(medium.to_medium.point(start.position)) || is_black(start.flux));
    sum += start.flux;
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(sum[c] / kPhotons, right[c], 0.01f * right[c]);
    EXPECT_NEAR(emission.power()[c], right[c], 0.2f * right[c]);
  }
}

TEST(MediumEmission, HomogeneousMediaEmitEvenlyInTheirBox) {
  Medium medium;
  medium.sigma_a = RGB(2.0f);
  medium.emission = RGB(1, 2, 3);
  const MediumEmission emission(7, medium, Box3{{1, 1, 1}, {2, 3, 4}}, false);
  EXPECT_EQ(emission.medium(), 7u);
  EXPECT_NEAR(emission.power().g, 4 * kPi * 4 * 6, 1e-3f);
  const MediumEmission::Start start = emission.sample(medium, {0.5f, 0.25f, 0.75f});
  EXPECT_NEAR(start.position.x, 1.5f, 1e-6f);
  EXPECT_NEAR(start.position.y, 1.5f, 1e-6f);
  EXPECT_NEAR(start.position.z, 3.25f, 1e-6f);
  EXPECT_NEAR(start.flux.b, emission.power().b, 1e-3f);
}

}  // namespace
}  // namespace glowworm
