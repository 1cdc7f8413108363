// Reverse photon mapping: the tree over query points, batched searches, and every instruction set against plain C++.
#include "density/reverse.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "density/density_scenes.h"
#include "density/radius.h"
#include "density/reverse_photons.h"
#include "density/reverse_reference.h"
#include "kernels/simd.h"

namespace glowworm::density_tests {
namespace {

std::vector<std::uint32_t> all(const QueryPoints& points) {
  std::vector<std::uint32_t> chosen(points.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = static_cast<std::uint32_t>(i);
  return chosen;
}

RadiusPolicy widely_varied(const PhotonBatch& photons, KernelShape kernel = KernelShape::epanechnikov) {
  RadiusPolicy policy;
  policy.kernel = kernel;
  policy.radii = per_photon_radii(photons, 30);
  for (std::size_t i = 0; i < policy.radii.size(); ++i) {
    policy.radii[i] *= 0.5f + 2 * to_unit_float(hash32(static_cast<std::uint32_t>(i)));
  }
  return policy;
}

/// Points of so many dimensions: all equal, on a line, on a plane, in space.
QueryPoints spread_points(std::size_t count, int dimensions) {
  QueryPoints points;
  for (std::size_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 5, 1, static_cast<std::uint32_t>(i));
    const Vec2 u = sampler.next2(), v = sampler.next2();
    const Vec3 p{dimensions > 0 ? u.x : 0.5f, dimensions > 1 ? u.y : 0.25f, dimensions > 2 ? v.x : 0.125f};
    add_query(points, p, normalize(Vec3{v.y - 0.5f, 0.25f, 1}));
  }
  return points;
}

/// Walks the tree and checks what must hold of it.
class ReverseTreeCheck {
 public:
  ReverseTreeCheck(const ReverseTree& tree, const QueryPoints& points, std::uint32_t leaf_size)
      : tree_(tree), points_(points), leaf_size_(leaf_size), seen_(points.size(), 0) {}

  void run() {
    ASSERT_EQ(tree_.size(), points_.size());
    Box3 everything{{-1e30f, -1e30f, -1e30f}, {1e30f, 1e30f, 1e30f}};
    next_point_ = 0;
    EXPECT_EQ(subtree(0, everything, 0), tree_.nodes().size());
    EXPECT_EQ(next_point_, tree_.size());
    for (const int times : seen_) EXPECT_EQ(times, 1);
    check_subtrees();
  }

 private:
  /// Returns the node behind the subtree.
  std::size_t subtree(std::uint32_t at, const Box3& cell, int depth) {
    EXPECT_LE(depth, ReverseNode::kMaxDepth);
    const ReverseNode node = tree_.nodes()[at];
    if (node.is_leaf()) {
      leaf(node, cell);
      return at + 1;
    }
    Box3 left = cell, right = cell;
    left.max[node.axis()] = node.split();
    right.min[node.axis()] = node.split();
    // Depth-first preorder: the right child follows all of the left one.
    EXPECT_EQ(subtree(at + 1, left, depth + 1), node.right());
    return subtree(node.right(), right, depth + 1);
  }

  void leaf(const ReverseNode& node, const Box3& cell) {
    EXPECT_EQ(node.first(), next_point_);
    ASSERT_GT(node.count(), 0u);
    const std::size_t n = node.count();
    const float* fields = tree_.points().data() + node.first() * kReverseFields;
    Box3 box;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 p{fields[i], fields[n + i], fields[2 * n + i]};
      EXPECT_TRUE(cell.contains(p));
      box.grow(p);
      std::uint32_t target, bsdf;
      std::memcpy(&target, fields + 6 * n + i, sizeof target);
      std::memcpy(&bsdf, fields + 7 * n + i, sizeof bsdf);
      ASSERT_LT(target, points_.size());
      ++seen_[target];
      EXPECT_TRUE(p == points_.position[target]);
      EXPECT_TRUE((Vec3{fields[3 * n + i], fields[4 * n + i], fields[5 * n + i]}) == points_.normal[target]);
      EXPECT_EQ(bsdf, points_.bsdf[target]);
    }
    if (length(box.diagonal()) > 0) {
      EXPECT_LE(n, leaf_size_);
    }
    EXPECT_GE(node.diagonal() * 1.00001f, length(box.diagonal()));
    next_point_ += static_cast<std::uint32_t>(n);
  }

  void check_subtrees() {
    std::uint32_t point = 0;
    for (const ReverseSubtree& part : tree_.subtrees()) {
      EXPECT_EQ(part.first_point, point);
      EXPECT_LE(part.point_count, ReverseTree::kSubtreePoints);
      std::uint32_t inside = 0;
      for (std::uint32_t i = 0; i < part.node_count; ++i) {
        const ReverseNode& node = tree_.nodes()[part.root + i];
        if (node.is_leaf()) inside += node.count();
      }
      EXPECT_EQ(inside, part.point_count);
      point += part.point_count;
    }
    EXPECT_EQ(point, tree_.size());
  }

  const ReverseTree& tree_;
  const QueryPoints& points_;
  std::uint32_t leaf_size_;
  std::uint32_t next_point_ = 0;
  std::vector<int> seen_;
};

TEST(ReverseNode, HoldsItsFields) {
  const ReverseNode inner = ReverseNode::inner(2, -1.25f, (1u << 28) - 1);
  EXPECT_FALSE(inner.is_leaf());
  EXPECT_EQ(inner.axis(), 2);
  EXPECT_EQ(inner.split(), -1.25f);
  EXPECT_EQ(inner.right(), (1u << 28) - 1);
  for (const float diagonal : {0.0f, 1e-30f, 0.1f, 1.0f, 1234.567f, 1e30f}) {
    const ReverseNode leaf = ReverseNode::leaf((1u << 30) - 1, 255, diagonal);
    EXPECT_TRUE(leaf.is_leaf());
    EXPECT_EQ(leaf.first(), (1u << 30) - 1);
    EXPECT_EQ(leaf.count(), 255u);
    EXPECT_GE(leaf.diagonal(), diagonal);
    EXPECT_LE(leaf.diagonal(), diagonal * (1 + 0x1p-15f));
  }
}

TEST(ReverseTree, HoldsEveryPointInItsCell) {
  for (const std::size_t count : {1, 2, 31, 32, 33, 1000, 50021}) {
    const QueryPoints points = room_queries(count);
    for (const std::uint32_t leaf_size : {1u, 8u, 32u, 255u}) {
      ReverseTreeCheck(ReverseTree(points, all(points), leaf_size), points, leaf_size).run();
    }
  }
}

TEST(ReverseTree, SplitsPointsOnAPlaneALineAndAPoint) {
  for (int dimensions = 0; dimensions <= 3; ++dimensions) {
    const QueryPoints points = spread_points(20011, dimensions);
    ReverseTreeCheck(ReverseTree(points, all(points), 30), points, 30).run();
  }
}

TEST(ReverseTree, KeepsSelectedFinitePoints) {
  QueryPoints points = room_queries(100);
  points.position[40].y = std::numeric_limits<float>::quiet_NaN();
  points.position[41].x = std::numeric_limits<float>::infinity();
  const std::vector<std::uint32_t> chosen{3, 40, 5, 41, 99};
  EXPECT_EQ(ReverseTree(points, chosen).size(), 3u);
  EXPECT_EQ(ReverseTree(points, {}).size(), 0u);
}

TEST(ReverseTree, IsTheSameForAnyNumberOfThreads) {
  const QueryPoints points = room_queries(100000);
  set_thread_count(1);
  const ReverseTree one(points, all(points));
  set_thread_count(2);
  const ReverseTree two(points, all(points));
  set_thread_count(0);
  ASSERT_EQ(one.nodes().size(), two.nodes().size());
  EXPECT_EQ(std::memcmp(one.nodes().data(), two.nodes().data(), one.nodes().size() * sizeof(ReverseNode)), 0);
  EXPECT_EQ(std::memcmp(one.points().data(), two.points().data(), one.points().size() * sizeof(float)), 0);
}

TEST(ReversePhotonArray, ClustersHoldTheirPhotonsSpheres) {
  const PhotonBatch photons = room_photons(20000);
  const RadiusPolicy policy = widely_varied(photons);
  for (const std::uint32_t size : {1u, 7u, 64u}) {
    const ReversePhotonArray array(photons, photons.flux, policy, size);
    const ReversePhotons view = array.view();
    ASSERT_EQ(array.size(), photons.size());
    std::uint32_t next = 0;
    for (const ReverseCluster& cluster : array.clusters()) {
      EXPECT_EQ(cluster.first, next);
      ASSERT_GE(cluster.count, 1u);
      ASSERT_LE(cluster.count, size);
      next += cluster.count;
      for (std::uint32_t i = cluster.first; i < next; ++i) {
        const double r = 1 / std::sqrt(double(view.inverse_radius_squared[i]));
        const double p[3] = {view.x[i], view.y[i], view.z[i]};
        double distance = 0;
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_LE(cluster.min[axis], p[axis] - r);
          EXPECT_GE(cluster.max[axis], p[axis] + r);
          distance += (p[axis] - cluster.center[axis]) * (p[axis] - cluster.center[axis]);
        }
        EXPECT_GE(cluster.radius, std::sqrt(distance) + r);
      }
    }
    EXPECT_EQ(next, photons.size());
    if (size == 64) {
      EXPECT_LT(array.clusters().size() * 10, photons.size());  // clusters are made, not photons on their own
    }
  }
}

std::vector<RGB> reverse(const ReverseOptions& options, const PhotonBatch& photons, const RadiusPolicy& policy,
                         const QueryPoints& points, Statistics& statistics) {
  const auto engine = make_reverse_engine(options);
  engine->build(photons, photons.flux, policy, statistics);
  std::vector<RGB> radiance(points.size(), RGB(0.0f));
  engine->estimate(points, radiance, statistics);
  return radiance;
}

TEST(ReverseEngine, BatchesFindTheSameAsSingleSearches) {
  const PhotonBatch photons = room_photons(5000);
  const QueryPoints points = room_queries(8000);
  for (const KernelShape kernel : {KernelShape::box, KernelShape::epanechnikov}) {
    const RadiusPolicy policy = widely_varied(photons, kernel);
    Statistics single_statistics;
    const std::vector<RGB> single = reverse({32, 1}, photons, policy, points, single_statistics);
    for (const std::uint32_t size : {2u, 15u, 64u}) {
      Statistics statistics;
      EXPECT_TRUE(single == reverse({32, size}, photons, policy, points, statistics)) << size;
      EXPECT_EQ(statistics.count(Counter::shader_operations), single_statistics.count(Counter::shader_operations));
    }
  }
}

TEST(ReverseEngine, AgreesForEveryLeafSize) {
  const PhotonBatch photons = room_photons(3000);
  const QueryPoints points = room_queries(2000);
  const RadiusPolicy policy = widely_varied(photons);
  const std::vector<RGB> expected = run("brute", photons, policy, points);
  for (const std::uint32_t leaf_size : {1u, 5u, 16u, 100u, 255u}) {
    Statistics statistics;
    EXPECT_LT(largest_difference(reverse({leaf_size, 64}, photons, policy, points, statistics), expected), 1e-5);
  }
}

TEST(ReverseEngine, AgreesWithForwardAndBlockedToRounding) {
  const PhotonBatch photons = room_photons(20000);
  const QueryPoints points = room_queries(24000);
  const RadiusPolicy policy = widely_varied(photons);
  const std::vector<RGB> values = run("reverse", photons, policy, points);
  EXPECT_LT(largest_difference(values, run("forward", photons, policy, points)), 1e-5);
  EXPECT_LT(largest_difference(values, run("blocked", photons, policy, points)), 1e-5);
}

TEST(ReverseEngine, FindsMoreCoincidentPointsThanALeafCounts) {
  PhotonBatch photons;
  add_photon(photons, {0.5f, 0.25f, 0.125f}, {0, 0, 1});
  add_photon(photons, {0.5f, 0.3f, 0.125f}, {0, 0, 1});
  QueryPoints points;
  for (int i = 0; i < 10000; ++i) add_query(points, {0.5f, 0.25f, 0.125f}, {0, 0, 1});
  RadiusPolicy policy;
  policy.radii = {0.1f, 0.1f};
  const std::vector<RGB> values = run("reverse", photons, policy, points);
  for (const RGB& value : values) EXPECT_TRUE(value == values[0]);
  EXPECT_GT(values[0].r, 0);
  EXPECT_LT(largest_difference({values[0]}, {run("brute", photons, policy, points)[0]}), 1e-6);
}

TEST(ReverseEngine, MatchesNormalsThatVaryWithinALeaf) {
  PhotonBatch photons;
  QueryPoints points;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    Sampler sampler(SamplerKind::independent, 4, 2, i);
    const Vec2 u = sampler.next2(), v = sampler.next2(), w = sampler.next2();
    const Vec3 normal = normalize(Vec3{w.x - 0.5f, w.y - 0.5f, v.y - 0.5f});
    add_photon(photons, {u.x, u.y, 0.1f * v.x}, normal);
    add_query(points, {u.y, v.x, 0.1f * u.x}, normal);
  }
  const RadiusPolicy policy = widely_varied(photons);
  EXPECT_LT(largest_difference(run("reverse", photons, policy, points), run("brute", photons, policy, points)), 1e-5);
}

TEST(ReverseEngine, RefusesOptionsOutOfRange) {
  EXPECT_THROW(make_reverse_engine({256, 1}), Error);
  EXPECT_THROW(make_reverse_engine({30, 0}), Error);
  EXPECT_THROW(make_reverse_engine({30, 65}), Error);
}

/// Sums and counts of all clusters against a whole tree.
struct ReverseAnswer {
  std::vector<float> sums;
  ReverseCounts counts;
};
template <class Function>
ReverseAnswer ask(const Function& function, const ReverseTree& tree, const ReversePhotonArray& photons) {
  constexpr float kSentinel = -7;
  ReverseAnswer answer;
  answer.sums.assign(tree.size() * kReverseSums, 0.0f);
  answer.sums.resize(answer.sums.size() + kReversePadding, kSentinel);
  for (const ReverseSubtree& subtree : tree.subtrees()) {
    std::vector<ReverseLeafBounds> bounds;
    ReverseSubtreeView part;
    part.nodes = tree.nodes().data();
    part.root = subtree.root;
    part.first_point = subtree.first_point;
    part.points = tree.points().data() + subtree.first_point * kReverseFields;
    part.sums = answer.sums.data() + subtree.first_point * kReverseSums;
    tree.measure(subtree, part.points, bounds);
    part.bounds = bounds.data();
    function(part, photons.view(), photons.clusters(), answer.counts);
  }
  // What stands behind the sums is read, never written.
  for (std::size_t i = tree.size() * kReverseSums; i < answer.sums.size(); ++i) EXPECT_EQ(answer.sums[i], kSentinel);
  return answer;
}

TEST(ReverseKernels, AgreeWithPlainCodeOnEveryInstructionSet) {
  const PhotonBatch photons = room_photons(2003);
  for (const std::size_t count : {1, 7, 8, 9, 31, 1013}) {
    const QueryPoints points = count == 1013 ? spread_points(count, 2) : room_queries(count);
    const ReverseTree tree(points, all(points));
    for (const KernelShape kernel : kKernelShapes) {
      const ReversePhotonArray array(photons, photons.flux, widely_varied(photons, kernel), 64);
      const ReverseAnswer expected = ask(reverse_sum_reference, tree, array);
      const float largest = *std::max_element(expected.sums.begin(), expected.sums.end());
      for (const std::string& name : simd_names()) {
        set_simd(name);
        const ReverseAnswer answer = ask(reverse_sum, tree, array);
        EXPECT_EQ(answer.counts.operations, expected.counts.operations) << name;
        EXPECT_LE(answer.counts.tested, expected.counts.tested) << name;
        for (std::size_t i = 0; i < answer.sums.size(); ++i)
          EXPECT_NEAR(answer.sums[i], expected.sums[i], 1e-5f * largest) << name << " " << i;
      }
      set_simd("auto");
    }
  }
}

TEST(ReverseKernels, CollectThePairsThatAreSummed) {
  const PhotonBatch photons = room_photons(3000);
  const QueryPoints points = room_queries(777);
  const ReverseTree tree(points, all(points));
  const ReversePhotonArray array(photons, photons.flux, widely_varied(photons), 64);
  const ReversePhotons view = array.view();
  for (const std::string& name : simd_names()) {
    set_simd(name);
    const ReverseAnswer expected = ask(reverse_sum, tree, array);
    std::vector<ReversePair> pairs;
    const ReverseAnswer collected = ask(
        [&](const ReverseSubtreeView& part, const ReversePhotons& all_photons, std::span<const ReverseCluster> clusters,
            ReverseCounts& counts) { reverse_collect(part, all_photons, clusters, pairs, counts); },
        tree, array);
    EXPECT_EQ(pairs.size(), expected.counts.operations);
    EXPECT_EQ(collected.counts.operations, expected.counts.operations);
    EXPECT_EQ(collected.counts.tested, expected.counts.tested);
    double green = 0, expected_green = 0;
    for (const ReversePair& pair : pairs) green += double(pair.profile) * view.g[pair.photon];
    for (const ReverseNode& node : tree.nodes()) {
      if (!node.is_leaf()) continue;
      for (std::size_t i = 0; i < node.count(); ++i)
        expected_green += expected.sums[node.first() * kReverseSums + node.count() + i];
    }
    EXPECT_NEAR(green, expected_green, 1e-5 * expected_green);
  }
  set_simd("auto");
}

}  // namespace
}  // namespace glowworm::density_tests
