// Vector kernels for sample numbers and diffuse directions: the same bits as scalar code on every instruction set.
#include "kernels/diffuse_rays.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/frame.h"
#include "core/random.h"
#include "kernels/diffuse_rays_reference.h"
#include "kernels/instruction_sets.h"
#include "kernels/sobol.h"

namespace glowworm {
namespace {

Vec3 unit_vector(std::uint32_t i, std::uint32_t which) {
  const float z = 2 * to_unit_float(hash_combine(i, which)) - 1;
  const float phi = 2 * kPi * to_unit_float(hash_combine(i, which + 1)), r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Points with frames of all directions, every seventh of which has a normal that faces away from its frame's.
struct Points {
  std::vector<std::uint32_t> sequence, sample;
  std::array<std::vector<float>, 9> frame;
  std::array<std::vector<float>, 3> normal;

  explicit Points(std::size_t n) : sequence(n + kDiffuseRayPadding), sample(n + kDiffuseRayPadding) {
    for (auto& array : frame) array.resize(n + kDiffuseRayPadding);
    for (auto& array : normal) array.resize(n + kDiffuseRayPadding);
    for (std::uint32_t i = 0; i < n; ++i) {
      sequence[i] = hash32(i);
      sample[i] = i % 37;
      const Frame f = Frame::from_normal(unit_vector(i, 1));
      const Vec3 axes[3] = {f.s, f.t, f.n};
      const Vec3 facing = i % 7 == 0 ? unit_vector(i, 5) : f.n;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t which = 0; which < 3; ++which) frame[3 * which + axis][i] = axes[which][axis];
        normal[axis][i] = facing[axis];
      }
    }
  }

  DiffuseRayPoints view(std::size_t n) const {
    DiffuseRayPoints out{n, sequence.data(), sample.data(), {}, {}};
    for (std::size_t i = 0; i < 9; ++i) out.frame[i] = frame[i].data();
    for (std::size_t i = 0; i < 3; ++i) out.normal[i] = normal[i].data();
    return out;
  }
};

struct Rays {
  std::array<std::vector<float>, 6> arrays;
  explicit Rays(std::size_t n) {
    for (auto& array : arrays) array.resize(n + kDiffuseRayPadding);
  }
  DiffuseSquare square() { return {arrays[4].data(), arrays[5].data()}; }
  DiffuseRays view() { return {{arrays[0].data(), arrays[1].data(), arrays[2].data()}, arrays[3].data()}; }
};

/// Holds `pairs(names, n, dimension, x, y)` to the samplers `sampler_of(name)`, on every instruction set.
template <typename Pairs, typename SamplerOf>
void expect_pairs_of(const Pairs& pairs, const SamplerOf& sampler_of) {
  constexpr std::size_t kMaxCount = 67;
  std::vector<std::uint32_t> names(kMaxCount);
  for (std::uint32_t i = 0; i < kMaxCount; ++i) names[i] = i < 40 ? i : hash32(i);
  on_every_instruction_set([&] {
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{16}, kMaxCount})
      for (std::uint32_t dimension = 0; dimension < 3; ++dimension) {
        std::vector<float> x(n + 1, -1.0f), y(n + 1, -1.0f);
        pairs(names.data(), n, dimension, x.data(), y.data());
        for (std::size_t i = 0; i < n; ++i) {
          Sampler sampler = sampler_of(names[i]);
          for (std::uint32_t d = 0; d < dimension; ++d) (void)sampler.next2();
          const Vec2 expected = sampler.next2();
          ASSERT_EQ(x[i], expected.x) << i << " of " << n << ", dimension " << dimension;
          ASSERT_EQ(y[i], expected.y) << i << " of " << n << ", dimension " << dimension;
        }
        EXPECT_EQ(x[n], -1.0f);
        EXPECT_EQ(y[n], -1.0f);
      }
  });
}

TEST(SobolPairs, AreTheSamplersBitForBit) {
  expect_pairs_of([](const std::uint32_t* index, std::size_t n, std::uint32_t dimension, float* x,
                     float* y) { sobol_pairs(Sampler::pair_key(5, 77, dimension), index, n, x, y); },
                  [](std::uint32_t index) { return Sampler(SamplerKind::sobol, 5, 77, index); });
}

TEST(SobolPairs, OfManySequencesAreTheSamplersBitForBit) {
  expect_pairs_of([](const std::uint32_t* sequence, std::size_t n, std::uint32_t dimension, float* x,
                     float* y) { sobol_pairs_of(5, sequence, n, 11, dimension, x, y); },
                  [](std::uint32_t sequence) { return Sampler(SamplerKind::sobol, 5, sequence, 11); });
}

TEST(DiffuseRays, AreThoseOfPlainLoopsBitForBit) {
  const DiffuseRayCell whole{3, 0x67617468u, 25, 11, {0, 0}, {1, 1}}, part{9, 17, 1, 0, {0.4f, 0.8f}, {0.2f, 0.2f}};
  for (const std::size_t n : {1u, 5u, 8u, 16u, 333u}) {
    const Points points(n);
    for (const DiffuseRayCell& cell : {whole, part}) {
      Rays expected(n);
      diffuse_squares_reference(points.view(n), cell, expected.square());
      diffuse_rays_reference(points.view(n), expected.square(), expected.view());
      on_every_instruction_set([&] {
        Rays made(n);
        diffuse_squares(points.view(n), cell, made.square());
        diffuse_rays(points.view(n), made.square(), made.view());
        for (std::size_t array = 0; array < made.arrays.size(); ++array)
          ASSERT_EQ(std::memcmp(made.arrays[array].data(), expected.arrays[array].data(), n * sizeof(float)), 0)
              << n << " points, array " << array;
      });
    }
  }
}

TEST(DiffuseRays, LeaveOnTheSideOfTheSurfaceWithTheDensityOfTwoImages) {
  constexpr std::size_t kPoints = 4096;
  const Points points(kPoints);
  Rays rays(kPoints);
  diffuse_squares(points.view(kPoints), {}, rays.square());
  diffuse_rays(points.view(kPoints), rays.square(), rays.view());
  std::size_t mirrored = 0;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const Vec3 d{rays.arrays[0][i], rays.arrays[1][i], rays.arrays[2][i]};
    EXPECT_NEAR(length(d), 1, 1e-6f);
    const Vec3 shading{points.frame[6][i], points.frame[7][i], points.frame[8][i]};
    const Vec3 normal{points.normal[0][i], points.normal[1][i], points.normal[2][i]};
    EXPECT_GT(dot(d, normal), 0);
    const Vec3 image = d - normal * (2 * dot(d, normal));
    EXPECT_NEAR(rays.arrays[3][i], std::max(dot(d, shading), 0.0f) + std::max(dot(image, shading), 0.0f), 1e-6f);
    mirrored += dot(d, shading) < 0;
  }
  EXPECT_GT(mirrored, 0u);
}

}  // namespace
}  // namespace glowworm
