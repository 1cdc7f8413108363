#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <vector>

#include "core/random.h"
#include "core/vec.h"
#include "kernels/blocked.h"
#include "kernels/blocked_reference.h"
#include "kernels/simd.h"

namespace glowworm {
namespace {

constexpr float kSentinel = -77.5f;

float number(std::uint32_t i, std::uint32_t which) { return to_unit_float(hash_combine(i, which)); }

Vec3 direction(std::uint32_t i, std::uint32_t which) {
  const float z = 2 * number(i, which) - 1, phi = 2 * kPi * number(i, which + 1), r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Up to 64 blocks of photons in the unit cube under one node or two levels of nodes, whose bounds are as wide as can
/// be.
struct Photons {
  std::vector<PhotonBlock> blocks;
  std::vector<BlockNode> nodes, root;
  BlockTree tree;

  Photons(std::size_t count, KernelShape kernel, float radius) {
    blocks.resize((count + kBlockWidth - 1) / kBlockWidth);
    for (std::size_t i = 0; i < blocks.size() * kBlockWidth; ++i) {
      PhotonBlock& block = blocks[i / kBlockWidth];
      const std::size_t lane = i % kBlockWidth;
      const auto index = static_cast<std::uint32_t>(i);
      const float r = radius * (0.5f + number(index, 9));
      const Vec3 n = direction(index, 5);
      block.x[lane] = number(index, 1);
      block.y[lane] = number(index, 2);
      block.z[lane] = number(index, 3);
      block.inverse_radius_squared[lane] = i < count ? 1 / (r * r) : std::numeric_limits<float>::infinity();
      block.nx[lane] = n.x;
      block.ny[lane] = n.y;
      block.nz[lane] = n.z;
      block.r[lane] = number(index, 20);
      block.g[lane] = number(index, 21);
      block.b[lane] = number(index, 22);
    }
    nodes.resize((blocks.size() + kBlockWidth - 1) / kBlockWidth);
    root.resize(1);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (int c = 0; c < kBlockWidth; ++c)
        set(nodes[i], c, i * kBlockWidth + static_cast<std::size_t>(c) < blocks.size());
    for (int c = 0; c < kBlockWidth; ++c) set(root[0], c, static_cast<std::size_t>(c) < nodes.size());
    tree.blocks = blocks.data();
    tree.level[0] = nodes.data();
    tree.level[1] = root.data();
    tree.levels = blocks.empty() ? 0 : 2;
    tree.kernel = kernel;
    tree.min_normal_cosine = 0.2f;
  }

  static void set(BlockNode& node, int child, bool there) {
    const float sign = there ? 1 : -1;
    node.min_x[child] = node.min_y[child] = node.min_z[child] = -1 * sign;
    node.max_x[child] = node.max_y[child] = node.max_z[child] = 2 * sign;
    node.radius_squared[child] = there ? 100.0f : 0.0f;
    node.normal_x[child] = node.normal_y[child] = node.normal_z[child] = 0;
    node.normal_spread[child] = 1;
  }
};

/// A run of points, with sentinels around what is written.
struct PointRun {
  static constexpr std::size_t kMargin = 5;
  std::vector<float> in[6], out[3];
  QueryRun run;

  explicit PointRun(std::size_t count, float normal_spread) {
    const std::size_t padded = (count + kTileWidth - 1) / kTileWidth * kTileWidth;
    for (auto& array : in) array.resize(kMargin + padded);
    for (std::size_t i = 0; i < padded; ++i) {
      const auto index = static_cast<std::uint32_t>(std::min(i, count - 1)) + 1000;
      const Vec3 n = normalize(Vec3{0, 0, 1} + direction(index, 40) * normal_spread);
      in[0][kMargin + i] = number(index, 30);
      in[1][kMargin + i] = number(index, 31);
      in[2][kMargin + i] = number(index, 32);
      in[3][kMargin + i] = n.x;
      in[4][kMargin + i] = n.y;
      in[5][kMargin + i] = n.z;
    }
    for (auto& array : out) array.assign(padded + 2 * kMargin, kSentinel);
    run.count = count;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      run.position[axis] = in[axis].data() + kMargin;
      run.normal[axis] = in[axis + 3].data() + kMargin;
      run.sum[axis] = out[axis].data() + kMargin;
    }
  }

  void expect_sentinels() const {
    for (const auto& array : out)
      for (std::size_t i = 0; i < kMargin; ++i) {
        EXPECT_EQ(array[i], kSentinel);
        EXPECT_EQ(array[array.size() - 1 - i], kSentinel);
      }
  }
};

void expect_as_reference(const Photons& photons, std::size_t points, float normal_spread) {
  PointRun run(points, normal_spread), expected(points, normal_spread);
  BlockedCounts counts, expected_counts;
  BlockedScratch scratch;
  blocked_sum(photons.tree, run.run, scratch, counts);
  blocked_sum_reference(photons.tree, photons.blocks.size(), expected.run, expected_counts);
  EXPECT_EQ(counts.evaluated, expected_counts.evaluated);
  EXPECT_LE(counts.tested, expected_counts.tested);
  EXPECT_GE(counts.tested, counts.evaluated);
  run.expect_sentinels();
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < points; ++i)
      ASSERT_NEAR(run.run.sum[c][i], expected.run.sum[c][i], 1e-5f * expected.run.sum[c][i] + 1e-6f)
          << "channel " << c << " point " << i;
}

TEST(BlockedKernel, EveryInstructionSetAgreesWithPlainCode) {
  for (const std::string& name : simd_names()) {
    SCOPED_TRACE(name);
    set_simd(name);
    for (const KernelShape kernel : kKernelShapes)
      for (const std::size_t photons : {0, 1, 8, 13, 512})
        for (const std::size_t points : {1, 3, 16, 17, 512}) {
          SCOPED_TRACE(testing::Message()
                       << static_cast<int>(kernel) << ": " << photons << " photons, " << points << " points");
          expect_as_reference(Photons(photons, kernel, 0.3f), points, 0.0f);
          expect_as_reference(Photons(photons, kernel, 0.3f), points, 0.8f);
        }
  }
  set_simd("auto");
}

TEST(BlockedKernel, EmptiesFullListsOfPhotons) {
  // More photons than a list holds, all in support.
  Photons photons(512, KernelShape::epanechnikov, 5);
  photons.tree.min_normal_cosine = -2;
  for (BlockNode& node : photons.nodes)
    for (int c = 0; c < kBlockWidth; ++c) node.radius_squared[c] = 1000;
  // The same blocks again and again: children 8 i + c of every node of the root are those of the first.
  std::vector<PhotonBlock> many;
  for (int i = 0; i < 16; ++i) many.insert(many.end(), photons.blocks.begin(), photons.blocks.end());
  std::vector<BlockNode> nodes(many.size() / kBlockWidth, photons.nodes[0]), middle(nodes.size() / kBlockWidth);
  for (BlockNode& node : middle)
    for (int c = 0; c < kBlockWidth; ++c) Photons::set(node, c, true);
  std::vector<BlockNode> top((middle.size() + kBlockWidth - 1) / kBlockWidth);
  for (std::size_t i = 0; i < top.size(); ++i)
    for (int c = 0; c < kBlockWidth; ++c)
      Photons::set(top[i], c, i * kBlockWidth + static_cast<std::size_t>(c) < middle.size());
  std::vector<BlockNode> root(1);
  for (int c = 0; c < kBlockWidth; ++c) Photons::set(root[0], c, static_cast<std::size_t>(c) < top.size());
  photons.tree.blocks = many.data();
  photons.tree.level = {nodes.data(), middle.data(), top.data(), root.data()};
  photons.tree.levels = 4;
  PointRun run(20, 0.5f), expected(20, 0.5f);
  BlockedCounts counts, expected_counts;
  BlockedScratch scratch;
  blocked_sum(photons.tree, run.run, scratch, counts);
  blocked_sum_reference(photons.tree, many.size(), expected.run, expected_counts);
  EXPECT_EQ(counts.evaluated, 20u * 512 * 16);
  EXPECT_EQ(expected_counts.evaluated, counts.evaluated);
  for (std::size_t i = 0; i < 20; ++i)
    EXPECT_NEAR(run.run.sum[0][i], expected.run.sum[0][i], 1e-4f * expected.run.sum[0][i]);
}

TEST(BlockedKernel, FindsThePhotonsThatAreSummed) {
  for (const std::string& name : simd_names()) {
    SCOPED_TRACE(name);
    set_simd(name);
    for (const KernelShape kernel : kKernelShapes) {
      const Photons photons(301, kernel, 0.4f);
      for (std::uint32_t i = 0; i < 20; ++i) {
        PointRun run(1, 0.3f);
        for (std::size_t axis = 0; axis < 3; ++axis)
          run.in[axis][PointRun::kMargin] = number(i, 60 + static_cast<std::uint32_t>(axis));
        BlockedCounts counts, found_counts;
        blocked_sum_reference(photons.tree, photons.blocks.size(), run.run, counts);
        BlockedScratch scratch;
        std::vector<BlockedPhoton> found;
        const float position[3] = {run.run.position[0][0], run.run.position[1][0], run.run.position[2][0]};
        const float normal[3] = {run.run.normal[0][0], run.run.normal[1][0], run.run.normal[2][0]};
        blocked_find(photons.tree, position, normal, scratch, found, found_counts);
        EXPECT_EQ(found.size(), counts.evaluated);
        EXPECT_EQ(found_counts.evaluated, counts.evaluated);
        float sum = 0;
        for (const BlockedPhoton& f : found)
          sum += f.profile * photons.blocks[f.place / kBlockWidth].r[f.place % kBlockWidth];
        EXPECT_NEAR(sum, run.run.sum[0][0], 1e-5f * sum);
      }
    }
  }
  set_simd("auto");
}

}  // namespace
}  // namespace glowworm
