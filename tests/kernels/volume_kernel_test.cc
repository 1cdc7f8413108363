#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/random.h"
#include "core/vec.h"
#include "kernels/instruction_sets.h"
#include "kernels/volume.h"
#include "kernels/volume_reference.h"

namespace glowworm {
namespace {

float volume_number(std::uint32_t i, std::uint32_t which) { return to_unit_float(hash_combine(hash32(i), which)); }
Vec3 volume_direction(std::uint32_t i, std::uint32_t which) {
  const float z = 2 * volume_number(i, which) - 1, phi = 2 * kPi * volume_number(i, which + 1);
  const float r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// What both kinds of blocks have: places in the unit cube, directions and flux.
template <class Block>
void set_common(Block& block, std::size_t lane, std::uint32_t i, bool there) {
  const Vec3 d = i % 8 == 3 ? Vec3{0, 0, 1} : volume_direction(i, 5);
  block.x[lane] = volume_number(i, 1);
  block.y[lane] = volume_number(i, 2);
  block.z[lane] = volume_number(i, 3);
  block.dx[lane] = d.x;
  block.dy[lane] = d.y;
  block.dz[lane] = d.z;
  block.r[lane] = there ? volume_number(i, 20) : 0;
  block.g[lane] = there ? volume_number(i, 21) : 0;
  block.b[lane] = there ? volume_number(i, 22) : 0;
}
void set_lane(VolumePhotonBlock& block, std::size_t lane, std::uint32_t i, bool there) {
  set_common(block, lane, i, there);
  const float r = 0.3f * (0.5f + volume_number(i, 9));
  block.inverse_radius_squared[lane] = 1 / (r * r);
  // Every other photon has a wall, every fourth two, at up to a radius and a half.
  for (std::uint32_t n = 0; n < 2; ++n) {
    const bool none = n == 0 ? i % 2 == 0 : i % 4 != 3;
    const Vec3 wall =
        none ? Vec3{0, 0, 0} : volume_direction(i, 11 + 20 * n) * (1 / (1.5f * r * volume_number(i, 13 + 20 * n)));
    for (int axis = 0; axis < 3; ++axis) block.wall[n][axis][lane] = wall[axis];
  }
}
void set_lane(BeamBlock& block, std::size_t lane, std::uint32_t i, bool there) {
  set_common(block, lane, i, there);
  const float r = 0.3f * (0.5f + volume_number(i, 9));
  block.radius_squared[lane] = r * r;
  block.length[lane] = i % 16 == 7 ? 0 : 0.5f * volume_number(i, 10);
}

/// Up to 64 blocks in the unit cube under one node or two levels of nodes.
template <class Block>
struct Blocks {
  std::vector<Block> blocks;
  std::vector<VolumeNode> nodes, root;
  VolumeTree tree;

  explicit Blocks(std::size_t count) {
    blocks.resize((count + kVolumeBlock - 1) / kVolumeBlock);
    for (std::size_t i = 0; i < blocks.size() * kVolumeBlock; ++i)
      set_lane(blocks[i / kVolumeBlock], i % kVolumeBlock, static_cast<std::uint32_t>(std::min(i, count - 1)),
               i < count);
    nodes.resize((blocks.size() + kVolumeBlock - 1) / kVolumeBlock);
    root.resize(1);
    for (std::size_t i = 0; i < nodes.size() * kVolumeBlock; ++i)
      set_child(nodes[i / kVolumeBlock], i % kVolumeBlock, i < blocks.size());
    for (std::size_t i = 0; i < kVolumeBlock; ++i) set_child(root[0], i, i < nodes.size());
    tree.level = {nodes.data(), root.data()};
    tree.levels = blocks.empty() ? 0 : 2;
    set_blocks();
  }
  void set_blocks() {
    if constexpr (std::is_same_v<Block, BeamBlock>)
      tree.beams = blocks.data();
    else
      tree.photons = blocks.data();
  }

  static void set_child(VolumeNode& node, std::size_t c, bool there) {
    node.center_x[c] = node.center_y[c] = node.center_z[c] = 0.5f;
    node.half_x[c] = node.half_y[c] = node.half_z[c] = 1;
    node.radius[c] = there ? 1 : kNoRadius;
  }
};

/// Segments in and around the unit cube, with bounds around them all.
SegmentTile tile_of(std::size_t count, bool grey, bool isotropic) {
  SegmentTile tile{};
  tile.count = count;
  tile.grey = grey;
  tile.isotropic = isotropic;
  for (std::uint32_t i = 0; i < kSegmentTile; ++i) {
    const Vec3 d = i % 4 == 1 ? Vec3{0, 0, 1} : volume_direction(i, 40);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      tile.origin[axis][i] = volume_number(i, 30 + axis);
      tile.direction[axis][i] = d[static_cast<int>(axis)];
      tile.sigma_t[axis][i] = 2 * volume_number(i, grey ? 50 : 50 + axis);
    }
    tile.length[i] = i >= count ? -1 : i % 5 == 2 ? std::numeric_limits<float>::infinity() : volume_number(i, 60);
    tile.g[i] = isotropic ? 0 : 1.6f * volume_number(i, 70) - 0.8f;
  }
  tile.bounds = {{0.5f, 0.5f, 0.5f}, {0, 0, 1}, -10, 10, 10, 0.1f, 0};
  return tile;
}

template <class Block>
void expect_as_plain_code(const Blocks<Block>& blocks, std::size_t segments, bool grey, bool isotropic) {
  SCOPED_TRACE(testing::Message() << blocks.blocks.size() << " blocks, " << segments << " segments");
  SegmentTile tile = tile_of(segments, grey, isotropic), expected = tile;
  VolumeCounts counts, expected_counts;
  VolumeScratch scratch;
  sum_volume(blocks.tree, tile, scratch, counts);
  sum_volume_reference(blocks.blocks.data(), blocks.blocks.size(), expected, expected_counts);
  // Rounding decides whether pairs at the rim count; they add next to nothing.
  EXPECT_NEAR(static_cast<double>(counts.evaluated), static_cast<double>(expected_counts.evaluated), 2);
  EXPECT_EQ(counts.tested, expected_counts.tested);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < segments; ++i)
      ASSERT_NEAR(tile.sum[c][i], expected.sum[c][i], 1e-4f * expected.sum[c][i] + 1e-5f) << c << ' ' << i;
}

template <class Block>
void expect_all_as_plain_code() {
  on_every_instruction_set([] {
    for (const std::size_t count : {0, 1, 8, 13, 500})
      for (const std::size_t segments : {1, 2, 7, 16})
        for (const bool grey : {false, true})
          for (const bool isotropic : {false, true})
            expect_as_plain_code(Blocks<Block>(count), segments, grey, isotropic);
  });
}

TEST(VolumeKernel, PhotonsOnEveryInstructionSetAgreeWithPlainCode) { expect_all_as_plain_code<VolumePhotonBlock>(); }
TEST(VolumeKernel, BeamsOnEveryInstructionSetAgreeWithPlainCode) { expect_all_as_plain_code<BeamBlock>(); }

template <class Block>
void expect_same_bits_alone() {
  const Blocks<Block> blocks(500);
  on_every_instruction_set([&] {
    for (const bool grey : {false, true}) {
      SegmentTile tile = tile_of(kSegmentTile, grey, false);
      VolumeCounts counts;
      VolumeScratch scratch;
      sum_volume(blocks.tree, tile, scratch, counts);
      for (std::size_t i = 0; i < kSegmentTile; ++i) {
        SegmentTile one = tile;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          one.origin[axis][0] = tile.origin[axis][i];
          one.direction[axis][0] = tile.direction[axis][i];
          one.sigma_t[axis][0] = tile.sigma_t[axis][i];
        }
        one.length[0] = tile.length[i];
        one.g[0] = tile.g[i];
        one.count = 1;
        sum_volume(blocks.tree, one, scratch, counts);
        for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(one.sum[c][0], tile.sum[c][i]) << c << ' ' << i;
      }
    }
  });
}

TEST(VolumeKernel, SegmentsHaveTheSameBitsAlone) {
  expect_same_bits_alone<VolumePhotonBlock>();
  expect_same_bits_alone<BeamBlock>();
}

TEST(VolumeKernel, EmptiesFullListsOfPhotons) {
  // More photons than a list holds: the same blocks again and again.
  Blocks<VolumePhotonBlock> blocks(512);
  std::vector<VolumePhotonBlock> many;
  for (int i = 0; i < 16; ++i) many.insert(many.end(), blocks.blocks.begin(), blocks.blocks.end());
  std::vector<VolumeNode> lowest(many.size() / kVolumeBlock, blocks.nodes[0]), middle(2, blocks.root[0]);
  middle.resize(lowest.size() / kVolumeBlock, blocks.root[0]);
  std::vector<VolumeNode> top(2, blocks.root[0]), root(1);
  for (std::size_t c = 0; c < kVolumeBlock; ++c) Blocks<VolumePhotonBlock>::set_child(root[0], c, c < 2);
  blocks.blocks = many;
  blocks.tree.level = {lowest.data(), middle.data(), top.data(), root.data()};
  blocks.tree.levels = 4;
  blocks.set_blocks();
  expect_as_plain_code(blocks, 16, false, false);
}

}  // namespace
}  // namespace glowworm
