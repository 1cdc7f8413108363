#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/hilbert.h"
#include "core/parallel.h"
#include "core/random.h"
#include "density/reorder.h"

namespace glowworm {
namespace {

/// Points on the walls of a box, denser towards one corner.
std::vector<Vec3> points_on_walls(std::uint32_t n) {
  std::vector<Vec3> points(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    Sampler sampler(SamplerKind::independent, 11, 0, i);
    const Vec2 u = sampler.next2();
    Vec3 p{u.x * u.x, u.y, 0};
    const int axis = static_cast<int>(sampler.next1() * 3);
    std::swap(p[axis], p.z);
    points[i] = p;
  }
  return points;
}

double mean_step(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& order) {
  double sum = 0;
  for (std::size_t i = 1; i < order.size(); ++i) sum += length(points[order[i]] - points[order[i - 1]]);
  return sum / static_cast<double>(order.size() - 1);
}

void expect_permutation(std::vector<std::uint32_t> order, std::size_t n) {
  ASSERT_EQ(order.size(), n);
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(order[i], i);
}

ReorderSettings octree(std::uint32_t threshold, int depth = kAutomaticDepth) {
  return {ReorderMethod::octree, threshold, depth};
}
ReorderSettings radix(int depth = kAutomaticDepth) { return {ReorderMethod::radix, 16, depth}; }

const Box3 kUnit{{0, 0, 0}, {1, 1, 1}};

TEST(Reorder, NoneKeepsTheOrder) {
  const auto order = hilbert_order(points_on_walls(5), kUnit, 100, {ReorderMethod::none, 16, kAutomaticDepth});
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
}

TEST(Reorder, OctreeToFullDepthSortsByHilbertKeys) {
  const std::vector<Vec3> points = points_on_walls(40000);
  const auto order = hilbert_order(points, kUnit, 100, octree(1));
  expect_permutation(order, points.size());
  const CubeGrid grid(kUnit, kHilbertMaxBits);
  std::vector<std::uint64_t> keys;
  for (const std::uint32_t i : order) keys.push_back(hilbert_key_of_morton(grid.morton(points[i]), kHilbertMaxBits));
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end()));
}

TEST(Reorder, OctreeAndRadixAgreeAtTheSameDepth) {
  const std::vector<Vec3> points = points_on_walls(40000);
  for (const int depth : {0, 1, 4, 10, 11, 21})
    EXPECT_EQ(hilbert_order(points, kUnit, 100, octree(1, depth)), hilbert_order(points, kUnit, 100, radix(depth)))
        << depth;
}

TEST(Reorder, OctreeDoesNotDivideCellsBelowTheThreshold) {
  const std::vector<Vec3> points = points_on_walls(40000);
  const auto order = hilbert_order(points, kUnit, 100, octree(64));
  expect_permutation(order, points.size());
  // Indices rise within a cell that was left alone and fall, mostly, where the next begins; cells on a surface hold
  // between 64 and a quarter of it.
  std::size_t falls = 0;
  for (std::size_t i = 1; i < order.size(); ++i) falls += order[i] < order[i - 1];
  EXPECT_GT(falls, 40000u / 64);
  EXPECT_LT(falls, 40000u / 8);
}

TEST(Reorder, BringsNeighboursTogether) {
  const std::vector<Vec3> points = points_on_walls(20000);
  const double before = mean_step(points, hilbert_order(points, kUnit, 0, {ReorderMethod::none, 16, kAutomaticDepth}));
  for (const ReorderSettings& settings : {octree(16), radix()}) {
    const auto order = hilbert_order(points, kUnit, 20000, settings);
    expect_permutation(order, points.size());
    EXPECT_LT(mean_step(points, order), before / 15);
  }
}

TEST(Reorder, DoesNotDependOnThreads) {
  const std::vector<Vec3> points = points_on_walls(100000);
  for (const ReorderSettings& settings : {octree(16), radix()}) {
    set_thread_count(1);
    const auto one = hilbert_order(points, kUnit, 100000, settings);
    set_thread_count(3);
    const auto three = hilbert_order(points, kUnit, 100000, settings);
    set_thread_count(0);
    EXPECT_EQ(one, three);
  }
}

TEST(Reorder, AcceptsCoincidentAndNonFinitePoints) {
  std::vector<Vec3> points(50000, Vec3{0.3f, 0.3f, 0.3f});
  points[7] = {std::numeric_limits<float>::quiet_NaN(), 0, 0};
  points[8] = {std::numeric_limits<float>::infinity(), 0, 0};
  EXPECT_EQ(bounds_of(points).max, (Vec3{0.3f, 0.3f, 0.3f}));
  for (const ReorderSettings& settings : {octree(16), radix()}) {
    expect_permutation(hilbert_order(points, bounds_of(points), 100, settings), points.size());
    expect_permutation(hilbert_order({}, Box3(), 100, settings), 0);
  }
}

TEST(Reorder, AutomaticDepthGrowsWithPointsAndPhotons) {
  EXPECT_EQ(automatic_depth(0, 0), 0);
  EXPECT_EQ(automatic_depth(1, 1000000), 0);
  int before = 0;
  for (std::size_t points = 1; points < (std::size_t{1} << 34); points *= 2) {
    const int depth = automatic_depth(points, points);
    EXPECT_GE(depth, before);
    EXPECT_LE(depth, 10);
    before = depth;
  }
  EXPECT_LT(automatic_depth(10000000, 1000), automatic_depth(10000000, 2000000));
}

}  // namespace
}  // namespace glowworm
