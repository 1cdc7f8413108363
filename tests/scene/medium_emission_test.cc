#include "scene/medium_emission.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
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
    const MediumEmission::Start start = emission.sample(
        medium, {part(0.8191725133961645), part(0.6710436067037893), part(0.5497004779019703)}, {0.5f, 0.5f});
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
  const MediumEmission::Start start = emission.sample(medium, {0.5f, 0.25f, 0.75f}, {0, 0.5f});
  EXPECT_NEAR(start.position.x, 1.5f, 1e-6f);
  EXPECT_NEAR(start.position.y, 1.5f, 1e-6f);
  EXPECT_NEAR(start.position.z, 3.25f, 1e-6f);
  EXPECT_NEAR(start.direction.z, 1, 1e-6f);
  EXPECT_NEAR(start.flux.b, emission.power().b, 1e-3f);
}

/// A channel that hardly absorbs sends photons no farther if it doesn't emit.
TEST(MediumEmission, EndlessMediaReachAsFarAsTheChannelsThatEmit) {
  Medium grey, clear;
  grey.sigma_a = RGB(1.0f);
  clear.sigma_a = RGB(0.001f, 1, 1);
  grey.emission = clear.emission = RGB(0, 1, 1);
  const Box3 box{{-1, -1, -1}, {1, 1, 1}};
  const Vec3 u{0.9f, 0.3f, 0.6f};
  const auto far = [&](const Medium& m) { return length(MediumEmission(0, m, box, true).sample(m, u, {}).position); };
  EXPECT_GT(far(grey), 2.0f);
  EXPECT_EQ(far(clear), far(grey));
}

/// The light that comes straight from beyond to a ball is that of its equilibrium with the medium, pi L on each
/// place of its surface, whatever the medium's density.
TEST(MediumEmission, EndlessMediaLightTheBallFromBeyond) {
  const Box3 box{{-1, 0, 2}, {3, 4, 4}};
  const float radius = 3;
  for (const float sigma_a : {1.0f, 0.1f, 0.01f, 0.001f}) {
    Medium medium;
    medium.sigma_a = RGB(sigma_a);
    medium.emission = RGB(1, 2, 4);
    const MediumEmission emission(0, medium, box, true);
    constexpr int kPhotons = 50'000;
    double sum = 0;
    for (int i = 0; i < kPhotons; ++i) {
      Sampler sampler(SamplerKind::sobol, 0, 1, static_cast<std::uint32_t>(i));
      const Vec2 a = sampler.next2(), b = sampler.next2(), c = sampler.next2();
      const MediumEmission::Start start = emission.sample(medium, {a.x, b.x, b.y}, c);
      const Vec3 offset = start.position - box.center();
      const float nearest = -dot(offset, start.direction);
      const float inside = radius * radius - length_squared(cross(offset, start.direction));
      if (length(offset) < radius || nearest < 0 || inside < 0) continue;
      sum += start.flux.g * std::exp(-sigma_a * (nearest - std::sqrt(inside))) / kPhotons;
    }
    const double right = 2 * 4 * kPi * kPi * radius * radius;
    EXPECT_NEAR(sum, right, 0.01 * right) << sigma_a;
    EXPECT_NEAR(emission.power().g, right * (1 + 4 * radius * sigma_a / 3), 1e-5 * right) << sigma_a;
  }
}

}  // namespace
}  // namespace glowworm
