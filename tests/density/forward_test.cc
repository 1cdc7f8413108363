// Forward SIMD photon mapping: the tree, and every instruction set and packet width against plain C++.
#include "density/forward.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "density/density_scenes.h"
#include "density/forward_reference.h"
#include "density/radius.h"
#include "kernels/simd.h"

namespace glowworm::density_tests {
namespace {

constexpr int kWidths[] = {1, 4, 8, 16};

RadiusPolicy per_photon(const PhotonBatch& photons, KernelShape kernel = KernelShape::epanechnikov) {
  RadiusPolicy policy;
  policy.kernel = kernel;
  policy.radii = per_photon_radii(photons, 30);
  for (std::size_t i = 0; i < policy.radii.size(); i += 5) policy.radii[i] *= 2;
  return policy;
}

/// Checks that the photons under a node lie on the sides of its plane that they should, and within its reach.
struct TreeCheck {
  const ForwardMap& map;
  const RadiusPolicy& policy;
  std::vector<int> visits;

  Vec3 position(std::uint32_t node) const { return {map.hot[node].x, map.hot[node].y, map.hot[node].z}; }

  /// Returns the box around the photons of the subtree.
  Box3 subtree(std::uint32_t node, int depth, float reach_above) {
    EXPECT_LT(depth, 32);
    ++visits[node];
    Box3 box;
    box.grow(position(node));
    const float own_radius = std::sqrt(1 / map.hot[node].inverse_radius_squared);
    EXPECT_LE(own_radius, reach_above * 1.00001f);
    const std::uint32_t axis = map.nodes[node].split & ForwardNode::kAxisMask;
    if (axis == ForwardNode::kLeaf) return box;
    const float split = std::bit_cast<float>(map.nodes[node].split);
    const int a = static_cast<int>(axis);
    EXPECT_NEAR(split, position(node)[a], 1e-6f);
    EXPECT_LE(own_radius, map.reach[node].own * 1.00001f);
    const Box3 left = subtree(node + 1, depth + 1, map.reach[node].left);
    EXPECT_LE(left.max[a], position(node)[a]);
    box.grow(left);
    if (map.nodes[node].right != 0) {
      const Box3 right = subtree(map.nodes[node].right, depth + 1, map.reach[node].right);
      EXPECT_GE(right.min[a], position(node)[a]);
      box.grow(right);
    }
    return box;
  }
};

TEST(ForwardMap, HasEveryPhotonOnOneSplitPlane) {
  for (const std::size_t count : {1, 2, 3, 10, 1000, 20000}) {
    const PhotonBatch photons = room_photons(count);
    const RadiusPolicy policy = per_photon(photons);
    const ForwardMap map = build_forward_map(photons, photons.flux, policy);
    ASSERT_EQ(map.nodes.size(), count);
    TreeCheck check{map, policy, std::vector<int>(count, 0)};
    check.subtree(0, 0, std::numeric_limits<float>::infinity());
    for (const int visits : check.visits) EXPECT_EQ(visits, 1);
  }
}

/// Sums of a map at query points, by the reference (lanes 0) or by the kernels.
struct Answer {
  std::vector<RGB> values;
  ForwardCounts counts;
};

Answer ask(const ForwardTree& tree, const QueryPoints& points, int lanes) {
  std::vector<float> arrays[6], sums[3];
  const std::size_t room = points.size() + kForwardMaxLanes;
  constexpr float kSentinel = -77;
  for (auto& array : arrays) array.assign(room, 0.0f);
  for (auto& sum : sums) {
    sum.assign(room, kSentinel);
    std::fill_n(sum.begin(), points.size(), 0.0f);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      arrays[axis][i] = points.position[i][axis];
      arrays[axis + 3][i] = points.normal[i][axis];
    }
  }
  const ForwardQueries queries{arrays[0].data(), arrays[1].data(), arrays[2].data(), arrays[3].data(),
                               arrays[4].data(), arrays[5].data(), points.size()};
  Answer answer;
  float *r = sums[0].data(), *g = sums[1].data(), *b = sums[2].data();
  if (lanes == 0) {
    forward_gather_reference(tree, queries, r, g, b, answer.counts);
  } else {
    forward_gather(tree, queries, lanes, r, g, b, answer.counts);
  }
  for (std::size_t i = 0; i < points.size(); ++i) answer.values.emplace_back(sums[0][i], sums[1][i], sums[2][i]);
  for (const auto& sum : sums) {
    for (std::size_t i = points.size(); i < room; ++i) EXPECT_EQ(sum[i], kSentinel);
  }
  return answer;
}

class EveryInstructionSet : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { set_simd(GetParam()); }
  void TearDown() override { set_simd("auto"); }
};

TEST_P(EveryInstructionSet, GathersAsPlainCode) {
  const PhotonBatch photons = room_photons(1001);
  for (const KernelShape kernel : kKernelShapes) {
    const RadiusPolicy policy = per_photon(photons, kernel);
    const ForwardMap map = build_forward_map(photons, photons.flux, policy);
    for (const std::size_t count : {1, 3, 4, 15, 16, 17, 250}) {
      const QueryPoints points = room_queries(count);
      const Answer expected = ask(map.tree(policy), points, 0);
      for (const int lanes : kWidths) {
        const Answer answer = ask(map.tree(policy), points, lanes);
        EXPECT_LT(largest_difference(answer.values, expected.values), 1e-5)
            << int(kernel) << " " << count << " " << lanes;
        EXPECT_EQ(answer.counts.operations, expected.counts.operations);
        // A packet comes to a photon if one of its points does; together they come as often as they would alone.
        EXPECT_EQ(answer.counts.active, expected.counts.active);
        EXPECT_LE(answer.counts.shadings, expected.counts.shadings);
        EXPECT_LE(answer.counts.active, answer.counts.shadings * static_cast<std::uint64_t>(lanes));
      }
    }
  }
}

TEST_P(EveryInstructionSet, CollectsThePairsThatAreSummed) {
  const PhotonBatch photons = room_photons(2000);
  QueryPoints points = room_queries(37);
  const RadiusPolicy policy = per_photon(photons);
  const ForwardMap map = build_forward_map(photons, photons.flux, policy);
  const Answer expected = ask(map.tree(policy), points, 0);
  std::vector<float> arrays[6];
  for (auto& array : arrays) array.assign(points.size() + kForwardMaxLanes, 0.0f);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      arrays[axis][i] = points.position[i][axis];
      arrays[axis + 3][i] = points.normal[i][axis];
    }
  }
  const ForwardQueries queries{arrays[0].data(), arrays[1].data(), arrays[2].data(), arrays[3].data(),
                               arrays[4].data(), arrays[5].data(), points.size()};
  for (const int lanes : kWidths) {
    std::vector<ForwardPair> pairs;
    ForwardCounts counts;
    for (std::size_t first = 0; first < points.size(); first += static_cast<std::size_t>(lanes)) {
      forward_collect(map.tree(policy), queries, first, lanes, pairs, counts);
    }
    std::vector<RGB> sums(points.size(), RGB(0.0f));
    for (const ForwardPair& pair : pairs) {
      ASSERT_LT(pair.query, points.size());
      const float* flux = map.cold[pair.photon].flux;
      sums[pair.query] += RGB(flux[0], flux[1], flux[2]) * pair.profile;
    }
    EXPECT_LT(largest_difference(sums, expected.values), 1e-5) << lanes;
    EXPECT_EQ(counts.operations, pairs.size());
  }
}

TEST_P(EveryInstructionSet, EngineAgreesWithBruteForceAtEveryWidth) {
  const PhotonBatch photons = room_photons(3000);
  const QueryPoints points = room_queries(301);
  const RadiusPolicy policy = per_photon(photons);
  const std::vector<RGB> expected = run("brute", photons, policy, points);
  for (const int lanes : kWidths) {
    const auto engine = make_forward_engine({lanes, {ReorderMethod::octree, 16, kAutomaticDepth}});
    Statistics statistics;
    std::vector<RGB> values(points.size(), RGB(0.0f));
    engine->build(photons, photons.flux, policy, statistics);
    engine->estimate(points, values, statistics);
    EXPECT_LT(largest_difference(values, expected), 1e-5) << lanes;
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, EveryInstructionSet, testing::ValuesIn(simd_names()),
                         [](const testing::TestParamInfo<std::string>& name) { return name.param; });

double mean_lanes(const PhotonBatch& photons, const QueryPoints& points, int lanes, ReorderMethod method) {
  const auto engine = make_forward_engine({lanes, {method, 16, kAutomaticDepth}});
  Statistics statistics;
  std::vector<RGB> values(points.size(), RGB(0.0f));
  engine->build(photons, photons.flux, per_photon(photons), statistics);
  engine->estimate(points, values, statistics);
  return double(statistics.count(Counter::packet_active_lanes)) / double(statistics.count(Counter::packet_steps));
}

TEST(Forward, ReorderingFillsTheLanes) {
  // Query points denser than photons, as gathering makes them.
  const PhotonBatch photons = room_photons(2000);
  const QueryPoints points = room_queries(30000);
  for (const int lanes : {4, 16}) {
    const double unordered = mean_lanes(photons, points, lanes, ReorderMethod::none);
    const double ordered = mean_lanes(photons, points, lanes, ReorderMethod::octree);
    EXPECT_GE(unordered, 1);
    EXPECT_GT(ordered, 2 * unordered) << lanes;
    EXPECT_LE(ordered, lanes);
  }
  EXPECT_GT(mean_lanes(photons, points, 4, ReorderMethod::octree), 3.0);
}

TEST(Forward, RejectsUnsupportedOptions) {
  EXPECT_THROW(make_forward_engine({5, {}}), Error);
  RadiusPolicy policy;
  policy.kind = RadiusKind::nearest;
  Statistics statistics;
  const PhotonBatch photons = room_photons(10);
  EXPECT_THROW(make_engine("forward")->build(photons, photons.flux, policy, statistics), Error);
}

}  // namespace
}  // namespace glowworm::density_tests
