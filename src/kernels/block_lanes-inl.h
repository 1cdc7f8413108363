// Lanes across the eight items of a block; compiled once for every instruction set.
#if defined(GLOWWORM_KERNELS_BLOCK_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLOWWORM_KERNELS_BLOCK_LANES_INL_H_
#undef GLOWWORM_KERNELS_BLOCK_LANES_INL_H_
#else
#define GLOWWORM_KERNELS_BLOCK_LANES_INL_H_
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Items of a block, or children of a node.
constexpr std::size_t kBlockItems = 8;
using BlockTag = hn::CappedTag<float, kBlockItems>;
using BlockVector = hn::Vec<BlockTag>;
using BlockMask = hn::Mask<BlockTag>;

/// For each mask: the set lanes, in order.
struct LaneTable {
  alignas(8) std::uint8_t lanes[256][kBlockItems] = {};
  constexpr LaneTable() {
    for (unsigned bits = 0; bits < 256; ++bits)
      for (unsigned lane = 0, next = 0; lane < kBlockItems; ++lane)
        if (bits >> lane & 1) lanes[bits][next++] = static_cast<std::uint8_t>(lane);
  }
};
constexpr LaneTable kLaneTable;

/// Appends first + i for every set lane i to a list with room for another whole vector, and advances its end.
/// (CompressStore of Highway 1.0 copies its table to the stack each time.)
HWY_INLINE void append_lanes(BlockMask mask, std::uint32_t first, std::uint32_t*& end) {
  const BlockTag d;
  const hn::RebindToUnsigned<BlockTag> du;
  const hn::Rebind<std::uint8_t, BlockTag> du8;
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  const auto lanes = hn::PromoteTo(du, hn::LoadU(du8, kLaneTable.lanes[bits[0]]));
  hn::StoreU(hn::Add(lanes, hn::Set(du, first)), du, end);
  end += hwy::PopCount(bits[0]);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
