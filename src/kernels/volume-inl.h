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

/// Bytes of a block that tests of distance read.
template <class Block>
constexpr std::size_t kTestedBytes = 0;
template <>
constexpr std::size_t kTestedBytes<VolumePhotonBlock> = offsetof(VolumePhotonBlock, dx);
template <>
constexpr std::size_t kTestedBytes<BeamBlock> = offsetof(BeamBlock, r);

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
    const BlockVector s = split(position, way);
    const BlockVector radius = hn::Div(hn::Set(d, 1.0f), hn::Sqrt(hn::Load(d, block.inverse_radius_squared + lane)));
    const BlockVector reach = hn::Add(radius, rounding_);
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
    const BlockVector reach = hn::MulAdd(hn::Set(d, kBeamRounding), length,
                                         hn::Add(hn::Sqrt(hn::Load(d, block.radius_squared + lane)), rounding_));
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

/// Segments, one a lane or the same in all lanes.
template <class D>
struct SegmentLanes {
  hn::Vec<D> origin[3], direction[3], length, sigma_t[3], g;
  /// @param load returns the lanes of an array of a tile
  template <class Load>
  HWY_INLINE SegmentLanes(const SegmentTile& tile, const Load& load) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = load(tile.origin[axis]);
      direction[axis] = load(tile.direction[axis]);
      sigma_t[axis] = load(tile.sigma_t[axis]);
    }
    length = load(tile.length);
    g = load(tile.g);
  }
};

/// Photons or pieces of beams, one a lane or the same in all lanes.
template <class D>
struct PhotonLanes {
  static constexpr bool kIsTube = false;
  hn::Vec<D> place[3], travel[3], inverse_radius_squared, flux[3], wall[2][3];
  template <class Load>
  HWY_INLINE PhotonLanes(const VolumePhotonBlock& block, const Load& load)
      : place{load(block.x), load(block.y), load(block.z)},
        travel{load(block.dx), load(block.dy), load(block.dz)},
        inverse_radius_squared(load(block.inverse_radius_squared)),
        flux{load(block.r), load(block.g), load(block.b)},
        wall{{load(block.wall[0][0]), load(block.wall[0][1]), load(block.wall[0][2])},
             {load(block.wall[1][0]), load(block.wall[1][1]), load(block.wall[1][2])}} {}
};
template <class D>
struct PieceLanes {
  static constexpr bool kIsTube = true;
  hn::Vec<D> place[3], travel[3], radius_squared, length, flux[3];
  template <class Load>
  HWY_INLINE PieceLanes(const BeamBlock& block, const Load& load)
      : place{load(block.x), load(block.y), load(block.z)},
        travel{load(block.dx), load(block.dy), load(block.dz)},
        radius_squared(load(block.radius_squared)),
        length(load(block.length)),
        flux{load(block.r), load(block.g), load(block.b)} {}
};
template <class D>
HWY_INLINE PhotonLanes<D> lanes_of(D, const VolumePhotonBlock& block, auto load) {
  return PhotonLanes<D>(block, load);
}
template <class D>
HWY_INLINE PieceLanes<D> lanes_of(D, const BeamBlock& block, auto load) {
  return PieceLanes<D>(block, load);
}

/// Where light scatters into the segments: at distance t along them, with the kernel's weight (0 outside).
template <class D>
struct Crossing {
  hn::Mask<D> inside;
  hn::Vec<D> weight, t;
  hn::Vec<D> variance;  ///< of t where the tube of a beam is crossed, m^2
};

/// The way from a photon's place to the segment's line, at right angles to it, and the distance of its foot there.
template <class D>
HWY_INLINE hn::Vec<D> way_to(D d, const SegmentLanes<D>& segment, const hn::Vec<D>* place, hn::Vec<D>* way) {
  for (int axis = 0; axis < 3; ++axis) way[axis] = hn::Sub(segment.origin[axis], place[axis]);
  const auto back = dot3(d, way, segment.direction);
  for (int axis = 0; axis < 3; ++axis) way[axis] = hn::NegMulAdd(back, segment.direction[axis], way[axis]);
  return hn::Neg(back);
}

/// The line over which a wall folds the disc across a segment.
template <class D>
struct Fold {
  hn::Mask<D> before;  ///< whether the place lies before the line
  /// Squared distance of the mirror image minus that of the place, over the squared radius.
  hn::Vec<D> further;
  hn::Vec<D> along, slope;  ///< the wall along the segment, m^-1; the square of what it is across, m^-2
};
template <class D>
HWY_INLINE Fold<D> fold_over(D d, const hn::Vec<D>* wall, const hn::Vec<D>* way, const SegmentLanes<D>& segment,
                             hn::Vec<D> inverse_radius_squared) {
  const auto before = hn::Sub(hn::Set(d, 1.0f), dot3(d, wall, way)), along = dot3(d, wall, segment.direction);
  const auto slope = hn::Max(hn::NegMulAdd(along, along, dot3(d, wall, wall)), hn::Set(d, 1e-30f));
  const auto further = hn::Div(hn::Mul(hn::Set(d, 4.0f), before), slope);
  return {hn::Gt(before, hn::Zero(d)), hn::Mul(further, inverse_radius_squared), along, slope};
}

/// The weights of photons spread evenly across narrow gaps between facing walls; else those of their images.
template <class D>
HWY_INLINE hn::Vec<D> spread_in_gaps(D d, const PhotonLanes<D>& photon, const hn::Vec<D>* way, const Fold<D>& first,
                                     const Fold<D>& second, hn::Vec<D> disc, hn::Vec<D> images) {
  const auto one = hn::Set(d, 1.0f), to_wall = dot3(d, photon.wall[0], way);
  const auto cosine = hn::NegMulAdd(first.along, second.along, dot3(d, photon.wall[0], photon.wall[1]));
  const auto lengths = hn::Mul(hn::Sqrt(first.slope), hn::Sqrt(second.slope));
  const auto gap = hn::Mul(hn::Add(hn::Div(one, hn::Sqrt(first.slope)), hn::Div(one, hn::Sqrt(second.slope))),
                           hn::Sqrt(photon.inverse_radius_squared));
  const auto is_narrow =
      hn::And(hn::Lt(cosine, hn::Mul(hn::Set(d, kFacing), lengths)), hn::Lt(gap, hn::Set(d, kNarrowGap)));
  // The integral of the disc along the line across the gap.
  const auto half = hn::MulAdd(hn::Div(hn::Mul(to_wall, to_wall), first.slope), photon.inverse_radius_squared, disc);
  const auto line = hn::Mul(hn::Set(d, 4.0f / 3), hn::Mul(half, hn::Sqrt(hn::Max(half, hn::Zero(d)))));
  return hn::IfThenElse(is_narrow, hn::Div(line, gap), images);
}

template <class D>
HWY_INLINE Crossing<D> cross(D d, const SegmentLanes<D>& segment, const PhotonLanes<D>& photon) {
  hn::Vec<D> way[3];
  const auto t = way_to(d, segment, photon.place, way);
  const auto u = hn::Mul(dot3(d, way, way), photon.inverse_radius_squared), one = hn::Set(d, 1.0f);
  auto inside = hn::And(hn::Lt(u, one), hn::And(hn::Ge(t, hn::Zero(d)), hn::Le(t, segment.length)));
  auto weight = hn::Sub(one, u);
  const auto zero = hn::Zero(d);
  const auto is_there = [&](const hn::Vec<D>* wall)
                            HWY_ATTR { return !hn::AllFalse(d, hn::Gt(dot3(d, wall, wall), zero)); };
  if (!hn::AllFalse(d, inside) && is_there(photon.wall[0])) {
    const Fold<D> first = fold_over(d, photon.wall[0], way, segment, photon.inverse_radius_squared);
    auto image = hn::Sub(weight, first.further), images = hn::Max(image, zero);
    inside = hn::And(inside, first.before);
    if (is_there(photon.wall[1])) {
      const Fold<D> second = fold_over(d, photon.wall[1], way, segment, photon.inverse_radius_squared);
      inside = hn::And(inside, second.before);
      images = hn::Add(images, hn::Max(hn::Sub(weight, second.further), zero));
      images = hn::Add(images, hn::Max(hn::Sub(image, second.further), zero));
      weight = spread_in_gaps(d, photon, way, first, second, weight, hn::Add(weight, images));
    } else {
      weight = hn::Add(weight, images);
    }
  }
  return {inside, hn::IfThenElseZero(inside, weight), hn::IfThenElseZero(inside, t), hn::Zero(d)};
}

/// From the foot of the piece's beginning on the segment, the square distance from the beam is A + 2 B t + C t^2, and
/// the coordinate along the beam s + c t.
template <class D>
HWY_INLINE Crossing<D> cross(D d, const SegmentLanes<D>& segment, const PieceLanes<D>& piece) {
  hn::Vec<D> way[3], across[3];
  const auto foot = way_to(d, segment, piece.place, way);
  const auto cosine = dot3(d, segment.direction, piece.travel), s = dot3(d, way, piece.travel);
  for (int axis = 0; axis < 3; ++axis) {
    way[axis] = hn::NegMulAdd(s, piece.travel[axis], way[axis]);
    across[axis] = hn::NegMulAdd(cosine, piece.travel[axis], segment.direction[axis]);
  }
  // Parallel beams have any crossing, which the piece's ends bound.
  const auto least = hn::Set(d, 1e-30f), zero = hn::Zero(d);
  const auto a = dot3(d, way, way), b = dot3(d, way, across), c = hn::Max(dot3(d, across, across), least);
  const auto discriminant = hn::MulAdd(b, b, hn::Mul(c, hn::Sub(piece.radius_squared, a)));
  // C times how far the crossing of the lines lies beyond the piece's ends. The tube's crossing reaches r c /
  // sin(theta) along the beam to either side.
  const auto at = hn::NegMulAdd(cosine, b, hn::Mul(s, c));
  const auto beyond = hn::Max(hn::Neg(at), hn::NegMulAdd(piece.length, c, at)), excess = hn::Max(beyond, zero);
  hn::Mask<D> inside =
      hn::And(hn::Gt(discriminant, zero), hn::Le(hn::Mul(excess, excess), hn::Mul(piece.radius_squared, c)));
  if (hn::AllFalse(d, inside)) return {inside, zero, zero, zero};

  const auto one = hn::Set(d, 1.0f);
  const auto per_c = hn::Div(one, c), root = hn::Sqrt(hn::IfThenElseZero(inside, discriminant));
  const auto per_cosine = hn::Div(one, hn::CopySign(hn::Max(hn::Abs(cosine), least), cosine));
  const auto begin = hn::Neg(hn::Mul(s, per_cosine)), end = hn::Mul(hn::Sub(piece.length, s), per_cosine);
  const auto low = hn::Max(hn::Max(hn::Neg(hn::Mul(hn::Add(b, root), per_c)), hn::Min(begin, end)), hn::Neg(foot));
  const auto high =
      hn::Min(hn::Min(hn::Mul(hn::Sub(root, b), per_c), hn::Max(begin, end)), hn::Sub(segment.length, foot));
  inside = hn::And(inside, hn::Lt(low, high));
  // The kernel is p0 + p1 x + p2 x^2 at x from the middle of the crossing, up to `half` of its length.
  const auto half = hn::Mul(hn::Set(d, 0.5f), hn::Sub(high, low)),
             middle = hn::Mul(hn::Set(d, 0.5f), hn::Add(low, high));
  const auto scale = hn::Neg(hn::Div(one, piece.radius_squared));
  const auto slope = hn::MulAdd(c, middle, b);
  const auto p0 = hn::MulAdd(hn::MulAdd(middle, hn::Add(slope, b), a), scale, one);
  const auto p1 = hn::Mul(hn::Add(slope, slope), scale), p2 = hn::Mul(c, scale);
  // Its mean value, and the mean and variance of x that it weighs.
  const auto third = hn::Mul(hn::Mul(half, half), hn::Set(d, 1.0f / 3));
  const auto mean = hn::MulAdd(p2, third, p0);
  inside = hn::And(inside, hn::Gt(mean, zero));
  const auto per_mean = hn::Div(third, mean), shift = hn::Mul(p1, per_mean);
  const auto square = hn::Mul(hn::MulAdd(hn::Mul(p2, third), hn::Set(d, 1.8f), p0), per_mean);
  const auto variance = hn::Max(hn::NegMulAdd(shift, shift, square), zero);
  return {inside, hn::IfThenElseZero(inside, hn::Mul(hn::Add(half, half), mean)),
          hn::IfThenElseZero(inside, hn::Add(hn::Add(middle, shift), foot)), hn::IfThenElseZero(inside, variance)};
}

/// Adds weight T p flux to sums of each channel. @param sum returns the place of a channel's sum
template <bool grey, bool isotropic, class D, class Photon, class Sum>
HWY_INLINE void add_crossing(D d, const SegmentLanes<D>& segment, const Photon& photon, const Crossing<D>& at,
                             const Sum& sum) {
  auto weight = at.weight;
  if constexpr (!isotropic) {
    // Light leaves the segment against its direction.
    const auto one = hn::Set(d, 1.0f), cosine = dot3(d, segment.direction, photon.travel);
    const auto x = hn::MulAdd(hn::Add(segment.g, segment.g), cosine, hn::MulAdd(segment.g, segment.g, one));
    weight = hn::Div(weight, hn::Mul(x, hn::Sqrt(x)));
  }
  // The mean of the transmittance over a crossing, to second order.
  const auto back = hn::Neg(at.t), half_variance = hn::Mul(at.variance, hn::Set(d, 0.5f));
  hn::Vec<D> seen = weight;
  for (int c = 0; c < 3; ++c) {
    if (c == 0 || !grey) {
      seen = hn::Mul(weight, hn::Exp(d, hn::Mul(back, segment.sigma_t[c])));
      if constexpr (Photon::kIsTube)
        seen = hn::MulAdd(seen, hn::Mul(hn::Mul(segment.sigma_t[c], segment.sigma_t[c]), half_variance), seen);
    }
    float* const to = sum(c);
    hn::Store(hn::MulAdd(seen, photon.flux[c], hn::Load(d, to)), d, to);
  }
}

/// Sums what is near a tile. Each segment has a sum for each lane of a block, which are added up at the end: so the
/// order is the same if lanes are segments, as they are if these have many photons in common, or photons.
template <class Block>
class TileSummer {
 public:
  TileSummer(const Block* blocks, const VolumeTree& tree, SegmentTile& tile, VolumeScratch& scratch,
             VolumeCounts& counts)
      : blocks_(blocks), tree_(tree), tile_(tile), scratch_(scratch), counts_(counts) {
    for (auto& channel : sums_)
      for (auto& lane : channel)
        for (float& sum : lane) sum = 0;
  }

  void run() {
    if (tree_.levels > 0 && tile_.count > 0) {
      const BoundsOfTile bounds(tile_.bounds);
      find_blocks(bounds);
      if (tile_.count > 1)
        list_photons(bounds);
      else
        with_flags([&](auto grey, auto isotropic) HWY_ATTR { add_blocks<grey(), isotropic()>(); });
    }
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < kSegmentTile; ++i) {
        // The sum of one segment has its lanes side by side.
        const auto part = [&](std::size_t lane) {
          return tile_.count > 1 ? sums_[c][lane][i] : i == 0 ? sums_[c][0][lane] : 0;
        };
        tile_.sum[c][i] = ((part(0) + part(1)) + (part(2) + part(3))) + ((part(4) + part(5)) + (part(6) + part(7)));
      }
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

  /// A block that the lists will come to.
  HWY_INLINE const Block& block(const std::uint32_t* i) const {
    if (scratch_.blocks.data() + blocks_found_ - i > kVolumeAhead) {
      const auto* ahead = reinterpret_cast<const char*>(&blocks_[i[kVolumeAhead]]);
      for (std::size_t line = 0; line < kTestedBytes<Block>; line += 64) __builtin_prefetch(ahead + line);
    }
    return blocks_[*i];
  }

  template <class Work>
  HWY_INLINE void with_flags(const Work& work) const {
    const std::true_type yes;
    const std::false_type no;
    if (tile_.grey)
      tile_.isotropic ? work(yes, yes) : work(yes, no);
    else
      tile_.isotropic ? work(no, yes) : work(no, no);
  }

  /// Many segments: lists the photons near them, which then meet a vector of segments each.
  void list_photons(const BoundsOfTile& bounds) {
    scratch_.list.resize(kVolumeList + 2 * kVolumeBlock);
    std::uint32_t* const list = scratch_.list.data();
    std::uint32_t* end = list;
    for (const std::uint32_t *i = scratch_.blocks.data(), *last = i + blocks_found_; i != last; ++i) {
      const Block& photons = block(i);
      for (std::size_t lane = 0; lane < kVolumeBlock; lane += hn::Lanes(BlockTag()))
        append_lanes(bounds.near(photons, lane), *i * kVolumeBlock + static_cast<std::uint32_t>(lane), end);
      if (end - list > static_cast<std::ptrdiff_t>(kVolumeList)) {
        with_flags([&](auto grey, auto isotropic) HWY_ATTR { add_list<grey(), isotropic()>(list, end); });
        end = list;
      }
    }
    with_flags([&](auto grey, auto isotropic) HWY_ATTR { add_list<grey(), isotropic()>(list, end); });
  }

  template <bool grey, bool isotropic>
  HWY_INLINE void add_list(const std::uint32_t* list, const std::uint32_t* end) {
    const SegmentTag d;
    const auto length = static_cast<std::uint64_t>(end - list);
    for (std::size_t first = 0; first < tile_.count; first += kSegmentLanes) {
      const SegmentLanes<SegmentTag> segments(tile_,
                                              [&](const float* array) HWY_ATTR { return hn::Load(d, array + first); });
      for (const std::uint32_t* i = list; i != end; ++i) {
        const std::size_t lane = *i % kVolumeBlock;
        const auto photon = lanes_of(d, blocks_[*i / kVolumeBlock],
                                     [&](const float* array) HWY_ATTR { return hn::Set(d, array[lane]); });
        const Crossing<SegmentTag> at = cross(d, segments, photon);
        if (hn::AllFalse(d, at.inside)) continue;
        counts_.evaluated += hn::CountTrue(d, at.inside);
        add_crossing<grey, isotropic>(d, segments, photon, at, [&](int c) { return sums_[c][lane] + first; });
      }
      counts_.tested += length * HWY_MIN(kSegmentLanes, tile_.count - first);
      counts_.steps += length;
    }
  }

  /// One segment: meets a vector of photons at once.
  template <bool grey, bool isotropic>
  HWY_INLINE void add_blocks() {
    const BlockTag d;
    const SegmentLanes<BlockTag> segment(tile_, [&](const float* array) HWY_ATTR { return hn::Set(d, array[0]); });
    for (const std::uint32_t *i = scratch_.blocks.data(), *last = i + blocks_found_; i != last; ++i) {
      const Block& photons = block(i);
      for (std::size_t lane = 0; lane < kVolumeBlock; lane += hn::Lanes(d)) {
        const auto photon =
            lanes_of(d, photons, [&](const float* array) HWY_ATTR { return hn::Load(d, array + lane); });
        const Crossing<BlockTag> at = cross(d, segment, photon);
        if (hn::AllFalse(d, at.inside)) continue;
        counts_.evaluated += hn::CountTrue(d, at.inside);
        add_crossing<grey, isotropic>(d, segment, photon, at, [&](int c) { return sums_[c][0] + lane; });
      }
    }
    counts_.tested += blocks_found_ * kVolumeBlock;
    counts_.steps += blocks_found_ * kVolumeBlock / hn::Lanes(d);
  }

  const Block* blocks_;
  const VolumeTree& tree_;
  SegmentTile& tile_;
  VolumeScratch& scratch_;
  VolumeCounts& counts_;
  std::size_t blocks_found_ = 0;
  alignas(64) float sums_[3][kVolumeBlock][kSegmentTile];
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
