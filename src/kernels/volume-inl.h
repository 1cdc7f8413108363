// The loops of maps of volume photons over vectors; compiled once for every instruction set.
#if defined(GLOWWORM_KERNELS_VOLUME_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLOWWORM_KERNELS_VOLUME_INL_H_
#undef GLOWWORM_KERNELS_VOLUME_INL_H_
#else
#define GLOWWORM_KERNELS_VOLUME_INL_H_
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include <type_traits>

#include "kernels/block_lanes-inl.h"
#include "kernels/volume.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
static_assert(kBlockItems == kVolumeBlock);

/// Lanes across segments.
using SegmentTag = hn::CappedTag<float, kSegmentTile>;
using SegmentVector = hn::Vec<SegmentTag>;
using SegmentMask = hn::Mask<SegmentTag>;
constexpr std::size_t kSegmentLanes = hn::MaxLanes(SegmentTag());

/// Capacity of a list of photons.
constexpr std::size_t kVolumeList = 4096;
/// Prefetch distance, in blocks.
constexpr std::ptrdiff_t kVolumeAhead = 3;

template <class D>
HWY_INLINE hn::Vec<D> dot3(D, const hn::Vec<D>* a, const hn::Vec<D>* b) {
  return hn::MulAdd(a[0], b[0], hn::MulAdd(a[1], b[1], hn::Mul(a[2], b[2])));
}

/// SegmentBounds, broadcast to the lanes of a block.
class BoundsOfTile {
 public:
  HWY_INLINE explicit BoundsOfTile(const SegmentBounds& bounds) {
    const BlockTag d;
    for (int axis = 0; axis < 3; ++axis) {
      point_[axis] = hn::Set(d, bounds.point[axis]);
      axis_[axis] = hn::Set(d, bounds.axis[axis]);
    }
    low_ = hn::Set(d, bounds.low);
    high_ = hn::Set(d, bounds.high);
    width_ = hn::Set(d, bounds.width);
    slope_ = hn::Set(d, bounds.slope);
    rounding_ = hn::Set(d, bounds.rounding);
  }

  /// Boxes of the children from `lane` on that a segment may come within their radius of.
  HWY_INLINE BlockMask near(const VolumeNode& node, std::size_t lane) const {
    const BlockTag d;
    const float* const center[3] = {node.center_x + lane, node.center_y + lane, node.center_z + lane};
    const float* const half[3] = {node.half_x + lane, node.half_y + lane, node.half_z + lane};
    BlockVector way[3];
    const BlockVector s = split(center, way);
    // The box's half extents along the axis, and times |way| along `way`.
    BlockVector along = hn::Zero(d), across = hn::Zero(d);
    for (int axis = 0; axis < 3; ++axis) {
      const BlockVector h = hn::Load(d, half[axis]);
      along = hn::MulAdd(hn::Abs(axis_[axis]), h, along);
      across = hn::MulAdd(hn::Abs(way[axis]), h, across);
    }
    const BlockVector squared = dot3(d, way, way);
    const BlockVector reach = hn::Add(hn::Load(d, node.radius + lane), rounding_);
    return hn::And(is_beside(s, along, reach),
                   hn::Le(hn::Sub(squared, across), hn::Mul(hn::Sqrt(squared), limit(hn::Add(s, along), reach))));
  }

  HWY_INLINE BlockMask near(const VolumePhotonBlock& block, std::size_t lane) const {
    const BlockTag d;
    const float* const position[3] = {block.x + lane, block.y + lane, block.z + lane};
    BlockVector way[3];
    const BlockVector s = split(position, way), reach = hn::Add(hn::Load(d, block.radius + lane), rounding_);
    return hn::And(is_beside(s, hn::Zero(d), reach), is_within(dot3(d, way, way), limit(s, reach)));
  }

  HWY_INLINE BlockMask near(const BeamBlock& block, std::size_t lane) const {
    const BlockTag d;
    const float* const position[3] = {block.x + lane, block.y + lane, block.z + lane};
    const float* const direction[3] = {block.dx + lane, block.dy + lane, block.dz + lane};
    const BlockVector length = hn::Load(d, block.length + lane);
    BlockVector way[3], beam[3];
    BlockVector s = split(position, way);
    BlockVector along = hn::Zero(d);
    for (int axis = 0; axis < 3; ++axis) {
      beam[axis] = hn::Mul(hn::Load(d, direction[axis]), length);
      along = hn::MulAdd(axis_[axis], beam[axis], along);
    }
    for (int axis = 0; axis < 3; ++axis) beam[axis] = hn::NegMulAdd(axis_[axis], along, beam[axis]);
    // The piece is nearest to the axis at this share of its length.
    const BlockVector beam_squared = hn::Max(dot3(d, beam, beam), hn::Set(d, 1e-30f));
    const BlockVector share =
        hn::Min(hn::Max(hn::Div(hn::Neg(dot3(d, way, beam)), beam_squared), hn::Zero(d)), hn::Set(d, 1.0f));
    for (int axis = 0; axis < 3; ++axis) way[axis] = hn::MulAdd(share, beam[axis], way[axis]);
    const BlockVector half = hn::Mul(hn::Set(d, 0.5f), hn::Abs(along));
    s = hn::MulAdd(hn::Set(d, 0.5f), along, s);
    const BlockVector reach =
        hn::MulAdd(hn::Set(d, kBeamRounding), length, hn::Add(hn::Load(d, block.radius + lane), rounding_));
    return hn::And(is_beside(s, half, reach), is_within(dot3(d, way, way), limit(hn::Add(s, half), reach)));
  }

 private:
  /// Places relative to the bounds: the coordinate on the axis, and the way from the axis.
  HWY_INLINE BlockVector split(const float* const* place, BlockVector* way) const {
    const BlockTag d;
    for (int axis = 0; axis < 3; ++axis) way[axis] = hn::Sub(hn::Load(d, place[axis]), point_[axis]);
    const BlockVector s = dot3(d, way, axis_);
    for (int axis = 0; axis < 3; ++axis) way[axis] = hn::NegMulAdd(s, axis_[axis], way[axis]);
    return s;
  }
  HWY_INLINE BlockMask is_beside(BlockVector s, BlockVector half, BlockVector reach) const {
    const BlockVector room = hn::Add(half, reach);
    return hn::And(hn::Ge(hn::Add(s, room), low_), hn::Le(hn::Sub(s, room), high_));
  }
  /// The distance from the axis within which segments and what is in their reach are, up to s along it.
  HWY_INLINE BlockVector limit(BlockVector s, BlockVector reach) const {
    return hn::Add(hn::MulAdd(slope_, hn::Min(hn::Add(s, reach), high_), width_), reach);
  }
  static HWY_INLINE BlockMask is_within(BlockVector squared, BlockVector limit) {
    return hn::And(hn::Ge(limit, hn::Zero(BlockTag())), hn::Le(squared, hn::Mul(limit, limit)));
  }

  BlockVector point_[3], axis_[3], low_, high_, width_, slope_, rounding_;
};

/// A tile's vector of segments.
template <bool grey, bool isotropic>
class SegmentGroup {
 public:
  HWY_INLINE SegmentGroup(SegmentTile& tile, std::size_t first) : tile_(tile), first_(first) {
    for (int axis = 0; axis < 3; ++axis) {
      origin_[axis] = load(tile.origin[axis]);
      direction_[axis] = load(tile.direction[axis]);
    }
    length_ = load(tile.length);
  }

  /// The way from the photon's place to the segment's line, and where it ends there.
  HWY_INLINE SegmentVector way_to(const float* place, SegmentVector* way) const {
    const SegmentTag d;
    for (int axis = 0; axis < 3; ++axis) way[axis] = hn::Sub(origin_[axis], hn::Set(d, place[axis * kVolumeBlock]));
    const SegmentVector back = dot3(d, way, direction_);
    for (int axis = 0; axis < 3; ++axis) way[axis] = hn::NegMulAdd(back, direction_[axis], way[axis]);
    return hn::Neg(back);
  }

  /// Adds weight T p flux, of light that travels so and scatters at t.
  HWY_INLINE void add(SegmentVector weight, SegmentVector t, const float* travel, float r, float g, float b) {
    const SegmentTag d;
    if constexpr (!isotropic) {
      // Light leaves the segment against its direction.
      SegmentVector cosine = hn::Mul(direction_[0], hn::Set(d, travel[0]));
      cosine = hn::MulAdd(direction_[1], hn::Set(d, travel[kVolumeBlock]), cosine);
      cosine = hn::MulAdd(direction_[2], hn::Set(d, travel[2 * kVolumeBlock]), cosine);
      const SegmentVector mean = load(tile_.g), one = hn::Set(d, 1.0f);
      const SegmentVector x = hn::MulAdd(hn::Add(mean, mean), cosine, hn::MulAdd(mean, mean, one));
      weight = hn::Div(weight, hn::Mul(x, hn::Sqrt(x)));
    }
    const SegmentVector back = hn::Neg(t);
    const SegmentVector grey_part = hn::Mul(weight, hn::Exp(d, hn::Mul(back, load(tile_.sigma_t[0]))));
    add_to(tile_.sum[0], grey_part, r);
    if constexpr (grey) {
      add_to(tile_.sum[1], grey_part, g);
      add_to(tile_.sum[2], grey_part, b);
    } else {
      add_to(tile_.sum[1], hn::Mul(weight, hn::Exp(d, hn::Mul(back, load(tile_.sigma_t[1])))), g);
      add_to(tile_.sum[2], hn::Mul(weight, hn::Exp(d, hn::Mul(back, load(tile_.sigma_t[2])))), b);
    }
  }

  SegmentVector direction_[3], length_;

 private:
  HWY_INLINE SegmentVector load(const float* array) const { return hn::Load(SegmentTag(), array + first_); }
  HWY_INLINE void add_to(float* sum, SegmentVector weight, float flux) {
    const SegmentTag d;
    hn::Store(hn::MulAdd(weight, hn::Set(d, flux), load(sum)), d, sum + first_);
  }

  SegmentTile& tile_;
  std::size_t first_;
  SegmentVector origin_[3];
};

/// Adds a photon to the segments within its radius; returns their number.
template <class Group>
HWY_INLINE std::size_t add_photon(const VolumePhotonBlock& block, std::size_t lane, Group& group) {
  const SegmentTag d;
  SegmentVector way[3];
  const SegmentVector t = group.way_to(block.x + lane, way);
  const SegmentVector u = hn::Mul(dot3(d, way, way), hn::Set(d, block.inverse_radius_squared[lane]));
  const SegmentVector one = hn::Set(d, 1.0f);
  const SegmentMask inside = hn::And(hn::Lt(u, one), hn::And(hn::Ge(t, hn::Zero(d)), hn::Le(t, group.length_)));
  if (hn::AllFalse(d, inside)) return 0;
  group.add(hn::IfThenElseZero(inside, hn::Sub(one, u)), hn::IfThenElseZero(inside, t), block.dx + lane, block.r[lane],
            block.g[lane], block.b[lane]);
  return hn::CountTrue(d, inside);
}

/// Adds a piece of a beam to the segments that cross its tube; returns their number.
///
/// From the foot of the piece's beginning on the segment, its square distance from the beam is A + 2 B t + C t^2, and
/// its coordinate along the beam s + c t.
template <class Group>
HWY_INLINE std::size_t add_photon(const BeamBlock& block, std::size_t lane, Group& group) {
  const SegmentTag d;
  const SegmentVector* const direction = group.direction_;
  SegmentVector way[3], beam[3], across[3];
  const SegmentVector foot = group.way_to(block.x + lane, way);
  for (int axis = 0; axis < 3; ++axis) beam[axis] = hn::Set(d, (block.dx + lane)[axis * kVolumeBlock]);
  const SegmentVector cosine = dot3(d, direction, beam), s = dot3(d, way, beam);
  for (int axis = 0; axis < 3; ++axis) {
    way[axis] = hn::NegMulAdd(s, beam[axis], way[axis]);
    across[axis] = hn::NegMulAdd(cosine, beam[axis], direction[axis]);
  }
  // Parallel beams have any crossing, which the piece's ends bound.
  const SegmentVector least = hn::Set(d, 1e-30f);
  const SegmentVector a = dot3(d, way, way), b = dot3(d, way, across), c = hn::Max(dot3(d, across, across), least);
  const SegmentVector radius_squared = hn::Set(d, block.radius_squared[lane]);
  const SegmentVector discriminant = hn::MulAdd(b, b, hn::Mul(c, hn::Sub(radius_squared, a)));
  SegmentMask inside = hn::Gt(discriminant, hn::Zero(d));
  if (hn::AllFalse(d, inside)) return 0;

  const SegmentVector one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f);
  const SegmentVector per_c = hn::Div(one, c), root = hn::Sqrt(hn::IfThenElseZero(inside, discriminant));
  const SegmentVector per_cosine = hn::Div(one, hn::CopySign(hn::Max(hn::Abs(cosine), least), cosine));
  const SegmentVector begin = hn::Neg(hn::Mul(s, per_cosine));
  const SegmentVector end = hn::Mul(hn::Sub(hn::Set(d, block.length[lane]), s), per_cosine);
  const SegmentVector low =
      hn::Max(hn::Max(hn::Neg(hn::Mul(hn::Add(b, root), per_c)), hn::Min(begin, end)), hn::Neg(foot));
  const SegmentVector high =
      hn::Min(hn::Min(hn::Mul(hn::Sub(root, b), per_c), hn::Max(begin, end)), hn::Sub(group.length_, foot));
  inside = hn::And(inside, hn::Lt(low, high));
  if (hn::AllFalse(d, inside)) return 0;

  const SegmentVector chord = hn::Sub(high, low), middle = hn::Mul(half, hn::Add(low, high));
  const SegmentVector squared = hn::MulAdd(middle, hn::MulAdd(c, middle, hn::Add(b, b)), a);
  const SegmentVector mean = hn::MulAdd(hn::Mul(hn::Mul(chord, chord), hn::Set(d, 1.0f / 12)), c, squared);
  const SegmentVector profile = hn::Max(hn::NegMulAdd(mean, hn::Div(one, radius_squared), one), hn::Zero(d));
  group.add(hn::IfThenElseZero(inside, hn::Mul(profile, chord)), hn::IfThenElseZero(inside, hn::Add(middle, foot)),
            block.dx + lane, block.r[lane], block.g[lane], block.b[lane]);
  return hn::CountTrue(d, inside);
}

/// Sums what is near a tile.
template <class Block>
class TileSummer {
 public:
  TileSummer(const Block* blocks, const VolumeTree& tree, SegmentTile& tile, VolumeScratch& scratch,
             VolumeCounts& counts)
      : blocks_(blocks), tree_(tree), tile_(tile), scratch_(scratch), counts_(counts) {}

  void run() {
    for (auto& sum : tile_.sum)
      for (float& s : sum) s = 0;
    if (tree_.levels == 0 || tile_.count == 0) return;
    const BoundsOfTile bounds(tile_.bounds);
    find_blocks(bounds);
    scratch_.list.resize(kVolumeList + 2 * kVolumeBlock);
    std::uint32_t* const list = scratch_.list.data();
    std::uint32_t* end = list;
    for (const std::uint32_t *i = scratch_.blocks.data(), *last = i + blocks_found_; i != last; ++i) {
      if (last - i > kVolumeAhead) {
        const auto* ahead = reinterpret_cast<const char*>(&blocks_[i[kVolumeAhead]]);
        for (std::size_t line = 0; line < sizeof(Block); line += 64) __builtin_prefetch(ahead + line);
      }
      for (std::size_t lane = 0; lane < kVolumeBlock; lane += hn::Lanes(BlockTag()))
        append_lanes(bounds.near(blocks_[*i], lane), *i * kVolumeBlock + static_cast<std::uint32_t>(lane), end);
      if (end - list > static_cast<std::ptrdiff_t>(kVolumeList)) {
        add(list, end);
        end = list;
      }
    }
    add(list, end);
  }

 private:
  /// Lists the blocks that may be near, in the order of the tree.
  void find_blocks(const BoundsOfTile& bounds) {
    std::vector<std::uint32_t>&above = scratch_.above, &below = scratch_.blocks;
    below.assign(1, 0);
    blocks_found_ = 1;
    for (int level = tree_.levels - 1; level >= 0; --level) {
      above.swap(below);
      if (below.size() < (blocks_found_ + 1) * kVolumeBlock) below.resize((blocks_found_ + 1) * kVolumeBlock);
      std::uint32_t* end = below.data();
      for (std::size_t i = 0; i < blocks_found_; ++i)
        for (std::size_t lane = 0; lane < kVolumeBlock; lane += hn::Lanes(BlockTag()))
          append_lanes(bounds.near(tree_.level[static_cast<std::size_t>(level)][above[i]], lane),
                       above[i] * kVolumeBlock + static_cast<std::uint32_t>(lane), end);
      blocks_found_ = static_cast<std::size_t>(end - below.data());
    }
  }

  void add(const std::uint32_t* list, const std::uint32_t* end) {
    if (tile_.grey)
      tile_.isotropic ? add<true, true>(list, end) : add<true, false>(list, end);
    else
      tile_.isotropic ? add<false, true>(list, end) : add<false, false>(list, end);
  }

  template <bool grey, bool isotropic>
  void add(const std::uint32_t* list, const std::uint32_t* end) {
    const auto length = static_cast<std::uint64_t>(end - list);
    for (std::size_t first = 0; first < tile_.count; first += kSegmentLanes) {
      SegmentGroup<grey, isotropic> group(tile_, first);
      for (const std::uint32_t* i = list; i != end; ++i)
        counts_.evaluated += add_photon(blocks_[*i / kVolumeBlock], *i % kVolumeBlock, group);
      counts_.tested += length * HWY_MIN(kSegmentLanes, tile_.count - first);
      counts_.steps += length;
    }
  }

  const Block* blocks_;
  const VolumeTree& tree_;
  SegmentTile& tile_;
  VolumeScratch& scratch_;
  VolumeCounts& counts_;
  std::size_t blocks_found_ = 0;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
