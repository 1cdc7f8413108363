// Kernels of boundary correction: the hits and sums of plain loops on every instruction set.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "core/random.h"
#include "kernels/boundary.h"
#include "kernels/boundary_reference.h"
#include "kernels/instruction_sets.h"

namespace glowworm {
namespace {

constexpr std::size_t kCounts[] = {0, 1, 7, 16, 33, 300};

/// Arrays of numbers in [-1, 1), with the padding.
template <std::size_t kArrays>
std::array<std::vector<float>, kArrays> numbers(std::size_t count, std::uint32_t seed) {
  std::array<std::vector<float>, kArrays> out;
  for (auto& array : out) {
    ++seed;
    array.resize(count + kBoundaryPadding);
    for (std::uint32_t i = 0; i < count; ++i) array[i] = 2 * to_unit_float(hash_combine(i, seed)) - 1;
  }
  return out;
}

TEST(BoundaryKernel, HitsAreThoseOfAPlainLoopBitForBit) {
  std::size_t all = 0;
  for (const std::size_t count : kCounts) {
    const auto a = numbers<6>(count, 1);
    const SegmentArrays segments{
        count, {a[0].data(), a[1].data(), a[2].data()}, {a[3].data(), a[4].data(), a[5].data()}};
    for (std::uint32_t i = 0; i < 20; ++i) {
      const auto v = numbers<9>(1, 100 * i);
      CornerAndEdges triangle{{v[0][0], v[1][0], v[2][0]}, {{v[3][0], v[4][0], v[5][0]}, {v[6][0], v[7][0], v[8][0]}}};
      for (auto& edge : triangle.edge)
        for (float& x : edge) x *= 3;
      // One without area.
      if (i == 18) std::copy_n(triangle.edge[0], 3, triangle.edge[1]);
      std::vector<std::uint32_t> expected(count + kBoundaryPadding), made(count + kBoundaryPadding);
      std::vector<float> expected_at(count + kBoundaryPadding), made_at(count + kBoundaryPadding);
      const float first = i % 2 == 0 ? 0.0f : 0.3f;
      const std::size_t found = segment_hits_reference(segments, triangle, first, expected.data(), expected_at.data());
      all += found;
      on_every_instruction_set([&] {
        ASSERT_EQ(segment_hits(segments, triangle, first, made.data(), made_at.data()), found);
        for (std::size_t j = 0; j < found; ++j) {
          EXPECT_EQ(made[j], expected[j]);
          EXPECT_EQ(made_at[j], expected_at[j]);
        }
      });
    }
  }
  EXPECT_GT(all, 100u);
}

TEST(BoundaryKernel, SumsAreThoseOfPlainLoops) {
  const KernelBall ball{{0.1f, -0.2f, 0.05f}, {0.48f, 0.36f, 0.8f}, 1 / 0.64f};
  for (const std::size_t count : kCounts) {
    const auto a = numbers<7>(count, 7);
    const WeightedPlaces places{
        count, {a[0].data(), a[1].data(), a[2].data()}, {a[3].data(), a[4].data(), a[5].data()}, a[6].data()};
    for (const KernelShape shape : kKernelShapes) {
      const double at_places = sum_at_places_reference(shape, places, ball, 0.1f);
      const double on_plane = sum_on_plane_reference(shape, a[0].data(), a[1].data(), count, ball);
      EXPECT_TRUE(count < 300 || on_plane > 10);
      on_every_instruction_set([&] {
        EXPECT_NEAR(sum_at_places(shape, places, ball, 0.1f), at_places, 1e-4);
        EXPECT_NEAR(sum_on_plane(shape, a[0].data(), a[1].data(), count, ball), on_plane, 1e-4);
      });
    }
  }
}

}  // namespace
}  // namespace glowworm
