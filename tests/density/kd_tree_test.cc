#include "density/kd_tree.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/parallel.h"
#include "core/random.h"

namespace glowworm {
namespace {

/// Checks a subtree; returns the node behind it. `next` is the first point that no leaf had yet.
std::size_t check(const KdTree& tree, std::size_t node_index, Box3 cell, int depth, std::uint32_t leaf_size,
                  std::uint32_t& next) {
  EXPECT_LT(depth, KdTree::kMaxDepth);
  const KdNode& node = tree.nodes[node_index];
  if (node.is_leaf()) {
    EXPECT_EQ(node.first(), next);
    EXPECT_GT(node.count, 0u);
    next += node.count;
    for (std::uint32_t i = node.first(); i < next; ++i) {
      EXPECT_TRUE(cell.contains(tree.points[i].position));
      if (node.count > leaf_size) {
        EXPECT_EQ(tree.points[i].position, tree.points[node.first()].position);
      }
    }
    return node_index + 1;
  }
  Box3 left = cell, right = cell;
  left.max[node.axis()] = node.split;
  right.min[node.axis()] = std::nextafter(node.split, std::numeric_limits<float>::infinity());
  const std::size_t behind_left = check(tree, node_index + 1, left, depth + 1, leaf_size, next);
  EXPECT_EQ(behind_left, node_index + node.right_offset());
  return check(tree, behind_left, right, depth + 1, leaf_size, next);
}

void check(const std::vector<Vec3>& points, std::uint32_t leaf_size) {
  const KdTree tree = build_kd_tree(points, leaf_size);
  ASSERT_EQ(tree.points.size(), points.size());
  std::vector<bool> seen(points.size(), false);
  for (const KdPoint& p : tree.points) {
    EXPECT_EQ(p.position, points[p.index]);
    EXPECT_FALSE(seen[p.index]);
    seen[p.index] = true;
  }
  std::uint32_t next = 0;
  EXPECT_EQ(check(tree, 0, tree.bounds, 0, leaf_size, next), tree.nodes.size());
  EXPECT_EQ(next, points.size());
}

Vec3 random_point(std::uint32_t i) {
  Sampler sampler(SamplerKind::independent, 5, 5, i);
  const Vec2 a = sampler.next2();
  return {a.x, a.y, sampler.next1()};
}

TEST(KdTree, HoldsEveryPointInItsCell) {
  for (const std::uint32_t count : {1u, 2u, 9u, 1000u, 40000u}) {
    std::vector<Vec3> points;
    for (std::uint32_t i = 0; i < count; ++i) points.push_back(random_point(i));
    for (const std::uint32_t leaf_size : {1u, 8u, 30u}) check(points, leaf_size);
  }
}

TEST(KdTree, SplitsPointsOnAPlaneALineAndAPoint) {
  for (int dimensions = 0; dimensions < 3; ++dimensions) {
    std::vector<Vec3> points;
    for (std::uint32_t i = 0; i < 2000; ++i) {
      const Vec3 p = random_point(i);
      points.push_back({dimensions > 0 ? p.x : 1, dimensions > 1 ? p.y : 2, 3});
    }
    check(points, 1);
    check(points, 8);
  }
}

TEST(KdTree, StaysShallowForEverSmallerDistances) {
  std::vector<Vec3> points;
  for (int i = 0; i < 140; ++i) {
    for (int copy = 0; copy < 20; ++copy) {
      points.push_back({std::ldexp(1.0f, -i), std::ldexp(1.0f, -(i / 2)), copy % 2 ? 0.0f : std::ldexp(1.0f, -i)});
    }
  }
  check(points, 1);
}

TEST(KdTree, SplitsNeighbouringFloats) {
  std::vector<Vec3> points;
  float x = 1;
  for (int i = 0; i < 64; ++i) {
    points.push_back({x, -x, 1});
    x = std::nextafter(x, 2.0f);
  }
  check(points, 1);
}

TEST(KdTree, IsEmptyWithoutPoints) { EXPECT_TRUE(build_kd_tree(std::span<const Vec3>(), 8).nodes.empty()); }

TEST(KdTree, IsTheSameForAnyNumberOfThreads) {
  std::vector<Vec3> points;
  for (std::uint32_t i = 0; i < 100000; ++i) points.push_back(random_point(i));
  set_thread_count(1);
  const KdTree one = build_kd_tree(points, 8);
  set_thread_count(2);
  const KdTree two = build_kd_tree(points, 8);
  set_thread_count(0);
  ASSERT_EQ(one.nodes.size(), two.nodes.size());
  for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(one.points[i].index, two.points[i].index);
  for (std::size_t i = 0; i < one.nodes.size(); ++i) ASSERT_EQ(one.nodes[i].bits, two.nodes[i].bits);
}

}  // namespace
}  // namespace glowworm
