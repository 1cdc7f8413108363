// The blocked engine's loops over vectors; compiled once for every instruction set.
#if defined(GLOWWORM_KERNELS_BLOCKED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLOWWORM_KERNELS_BLOCKED_INL_H_
#undef GLOWWORM_KERNELS_BLOCKED_INL_H_
#else
#define GLOWWORM_KERNELS_BLOCKED_INL_H_
#endif

#include <hwy/highway.h>

#include "kernels/block_lanes-inl.h"
#include "kernels/blocked.h"
#include "kernels/kernel_shape-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Makes the compiler read `array` again after this, instead of keeping it in registers.
#undef GLOWWORM_KEEP_IN_MEMORY
#define GLOWWORM_KEEP_IN_MEMORY(array) asm volatile("" : : "r"(array) : "memory")

static_assert(kBlockItems == kBlockWidth);
/// Lanes across query points.
using TileTag = hn::CappedTag<float, 16>;
using TileVector = hn::Vec<TileTag>;

constexpr std::size_t kTileLanes = hn::MaxLanes(TileTag());
/// Vectors that visit the photons together; more would exceed the registers of most instruction sets.
constexpr std::size_t kTileVectors = 2;
constexpr std::size_t kGroupWidth = kTileVectors * kTileLanes;
constexpr std::size_t kGroups = kTileWidth / kGroupWidth;
static_assert(kTileWidth % kGroupWidth == 0);

/// Margin for rounding in tests that must not lose a pair; the exact test follows.
constexpr float kRimMargin = 1 + 1e-5f;
constexpr float kNormalMargin = 1e-5f;

/// Capacity of a list of photons.
constexpr std::ptrdiff_t kListLength = 4096;
constexpr std::size_t kListRoom = kListLength + 2 * kBlockWidth;
/// Prefetch distance, in blocks.
constexpr std::ptrdiff_t kBlocksAhead = 3;

/// The box around some query points, and a vector within `spread` of all their normals.
struct QueryBounds {
  float min[3], max[3], normal[3], spread;
};

HWY_INLINE QueryBounds bounds_of(const QueryRun& run, std::size_t first, std::size_t width) {
  const TileTag d;
  QueryBounds bounds;
  TileVector mean[3];
  for (int axis = 0; axis < 3; ++axis) {
    TileVector low = hn::LoadU(d, run.position[axis] + first), high = low, sum = hn::LoadU(d, run.normal[axis] + first);
    for (std::size_t i = kTileLanes; i < width; i += kTileLanes) {
      const TileVector p = hn::LoadU(d, run.position[axis] + first + i);
      low = hn::Min(low, p);
      high = hn::Max(high, p);
      sum = hn::Add(sum, hn::LoadU(d, run.normal[axis] + first + i));
    }
    bounds.min[axis] = hn::GetLane(hn::MinOfLanes(d, low));
    bounds.max[axis] = hn::GetLane(hn::MaxOfLanes(d, high));
    mean[axis] = hn::Mul(hn::SumOfLanes(d, sum), hn::Set(d, 1.0f / static_cast<float>(width)));
    bounds.normal[axis] = hn::GetLane(mean[axis]);
  }
  TileVector spread = hn::Zero(d);
  for (std::size_t i = 0; i < width; i += kTileLanes) {
    TileVector square = hn::Zero(d);
    for (int axis = 0; axis < 3; ++axis) {
      const TileVector away = hn::Sub(hn::LoadU(d, run.normal[axis] + first + i), mean[axis]);
      square = hn::MulAdd(away, away, square);
    }
    spread = hn::Max(spread, square);
  }
  bounds.spread = hn::GetLane(hn::Sqrt(hn::MaxOfLanes(d, spread)));
  return bounds;
}

/// QueryBounds broadcast to the lanes of a block vector.
struct SpreadBounds {
  BlockVector min[3], max[3], normal[3], lowest_cosine;
  SpreadBounds() = default;
  HWY_INLINE SpreadBounds(const QueryBounds& bounds, float min_normal_cosine) {
    const BlockTag d;
    for (int axis = 0; axis < 3; ++axis) {
      min[axis] = hn::Set(d, bounds.min[axis]);
      max[axis] = hn::Set(d, bounds.max[axis]);
      normal[axis] = hn::Set(d, bounds.normal[axis]);
    }
    // n_q . n_p <= mean . n_p + spread, as |n_p| is 1.
    lowest_cosine = hn::Set(d, min_normal_cosine - bounds.spread - kNormalMargin);
  }
};

/// Appends first + i for every child i that may hold photons in support of a point in the bounds.
HWY_INLINE void append_children(const BlockNode& node, const SpreadBounds& q, std::uint32_t first,
                                std::uint32_t*& end) {
  const BlockTag d;
  const BlockVector zero = hn::Zero(d);
  for (std::size_t i = 0; i < kBlockWidth; i += hn::Lanes(d)) {
    const auto gap = [&](const float* low, const float* high, int axis) HWY_ATTR {
      return hn::Max(hn::Max(hn::Sub(hn::Load(d, low + i), q.max[axis]), hn::Sub(q.min[axis], hn::Load(d, high + i))),
                     zero);
    };
    const BlockVector x = gap(node.min_x, node.max_x, 0), y = gap(node.min_y, node.max_y, 1),
                      z = gap(node.min_z, node.max_z, 2);
    const BlockVector distance = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
    // n_q . n_p <= n_q . m + |n_p - m|, and n_q . m <= mean . m + spread |m| with |m| <= 1.
    const BlockVector cosine = hn::MulAdd(
        hn::Load(d, node.normal_x + i), q.normal[0],
        hn::MulAdd(hn::Load(d, node.normal_y + i), q.normal[1],
                   hn::MulAdd(hn::Load(d, node.normal_z + i), q.normal[2], hn::Load(d, node.normal_spread + i))));
    append_lanes(hn::And(hn::Lt(distance, hn::Load(d, node.radius_squared + i)), hn::Gt(cosine, q.lowest_cosine)),
                 first + static_cast<std::uint32_t>(i), end);
  }
}

/// Appends to scratch.nodes the nodes of level 0 that may hold photons in support of a point in the bounds.
inline void find_nodes(const BlockTree& tree, const QueryBounds& bounds, BlockedScratch& scratch) {
  scratch.nodes.clear();
  if (tree.levels == 0) return;
  const SpreadBounds q(bounds, tree.min_normal_cosine);
  // Level by level: one list holds the remaining nodes of a level, in order.
  std::vector<std::uint32_t>&above = scratch.blocks, &below = scratch.nodes;
  below.assign(1, 0);
  for (int level = tree.levels - 1; level > 0; --level) {
    above.swap(below);
    below.resize(above.size() * kBlockWidth + kBlockWidth);
    std::uint32_t* end = below.data();
    for (const std::uint32_t node : above) append_children(tree.level[level][node], q, node * kBlockWidth, end);
    below.resize(static_cast<std::size_t>(end - below.data()));
  }
}

/// What the planes of eight photons leave of the points in some bounds: none of them, or possibly not all. Each product
/// and each sum is monotonic in the point and in the order of cut_at(), so that rounding can't contradict it.
/// @param near the photons to test
struct CutBounds {
  BlockMask ends_before, crosses;
};
HWY_INLINE CutBounds cut_bounds(const PhotonBlock& block, const BlockCuts& cuts, std::size_t lane,
                                const SpreadBounds& q, BlockMask near) {
  const BlockTag d;
  const float* const position[3] = {block.x + lane, block.y + lane, block.z + lane};
  CutBounds found{hn::FirstN(d, 0), hn::FirstN(d, 0)};
  for (std::size_t c = 0; c < kCuts; ++c) {
    const BlockVector distance = hn::Load(d, cuts.distance[c] + lane);
    if (hn::AllFalse(d, hn::And(near, hn::IsFinite(distance)))) continue;
    BlockVector least[3], most[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const BlockVector p = hn::Load(d, position[axis]), n = hn::Load(d, cuts.normal[c][axis] + lane);
      const BlockVector a = hn::Mul(n, hn::Sub(p, q.min[axis])), b = hn::Mul(n, hn::Sub(p, q.max[axis]));
      least[axis] = hn::Min(a, b);
      most[axis] = hn::Max(a, b);
    }
    const auto sum = [](const BlockVector* x) HWY_ATTR { return hn::Add(hn::Add(x[0], x[1]), x[2]); };
    found.ends_before = hn::Or(found.ends_before, hn::Ge(sum(least), distance));
    found.crosses = hn::Or(found.crosses, hn::Ge(sum(most), distance));
  }
  return found;
}

/// The points on a photon's side of its planes. @param photon its place in floats @param position of the points
HWY_INLINE hn::Mask<TileTag> cut_at(const BlockTree& tree, std::uint32_t photon, const float* p, const float* x,
                                    const float* y, const float* z, hn::Mask<TileTag> inside) {
  constexpr auto kBlockFloats = static_cast<std::uint32_t>(sizeof(PhotonBlock) / sizeof(float));
  const BlockCuts* cuts = tree.cuts_of(photon / kBlockFloats);
  if (!cuts) return inside;
  const std::size_t lane = photon % kBlockFloats;
  const TileTag d;
  const float* const position[3] = {x, y, z};
  for (std::size_t c = 0; c < kCuts; ++c) {
    const auto product = [&](std::size_t axis) HWY_ATTR {
      return hn::Mul(hn::Set(d, cuts->normal[c][axis][lane]),
                     hn::Sub(hn::Set(d, p[axis * kBlockWidth]), hn::Load(d, position[axis])));
    };
    inside = hn::And(inside,
                     hn::Lt(hn::Add(hn::Add(product(0), product(1)), product(2)), hn::Set(d, cuts->distance[c][lane])));
  }
  return inside;
}

/// Sums the photons of lists at a group of query points. The sums stay in registers; the points are read from memory
/// each time, because most instruction sets have no registers left for them.
template <KernelShape shape>
class Group {
 public:
  HWY_INLINE void start(const QueryRun& run, const GlossyPoints*, std::size_t first) {
    first_ = first;
    valid_ = run.count > first ? HWY_MIN(run.count - first, kGroupWidth) : 0;
    const TileTag d;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < kGroupWidth; i += kTileLanes) {
        hn::Store(hn::Zero(d), d, sums_[axis] + i);
        hn::Store(hn::LoadU(d, run.position[axis] + first + i), d, position_[axis] + i);
        hn::Store(hn::LoadU(d, run.normal[axis] + first + i), d, normal_[axis] + i);
      }
    // Padding is beyond the reach of all photons.
    for (std::size_t i = valid_; i < kGroupWidth; ++i) position_[0][i] = 1e19f;
  }

  /// Number of points without padding.
  HWY_INLINE std::size_t valid() const { return valid_; }

  /// Adds the photons at floats list[0 .. length) of the tree's blocks. Returns the number of pairs inside.
  /// @param compare whether normals and planes may exclude some pair
  template <bool compare>
  HWY_INLINE std::uint64_t add(const BlockTree& tree, const std::uint32_t* list, std::size_t length) {
    const auto* photons = reinterpret_cast<const float*>(tree.blocks);
    const float min_normal_cosine = tree.min_normal_cosine;
    const TileTag d;
    const hn::RebindToSigned<TileTag> di;
    TileVector r[kTileVectors], g[kTileVectors], b[kTileVectors];
    for (std::size_t v = 0; v < kTileVectors; ++v) {
      r[v] = hn::Load(d, sums_[0] + v * kTileLanes);
      g[v] = hn::Load(d, sums_[1] + v * kTileLanes);
      b[v] = hn::Load(d, sums_[2] + v * kTileLanes);
    }
    auto inside_count = hn::Zero(di);
    const TileVector one = hn::Set(d, 1.0f);
    for (std::size_t i = 0; i < length; ++i) {
      GLOWWORM_KEEP_IN_MEMORY(position_);
      const float* p = photons + list[i];
      TileVector t[kTileVectors];
      square_distances(p, t);
      const TileVector scale = hn::Set(d, p[3 * kBlockWidth]);
      for (std::size_t v = 0; v < kTileVectors; ++v) {
        t[v] = hn::Mul(t[v], scale);
        hn::Mask<TileTag> inside = hn::Lt(t[v], one);
        if constexpr (compare) {
          // Without fused operations, for the same bits as the dot product of two Vec3.
          const auto product = [&](std::size_t axis) HWY_ATTR {
            return hn::Mul(hn::Load(d, normal_[axis] + v * kTileLanes), hn::Set(d, p[(4 + axis) * kBlockWidth]));
          };
          inside = hn::And(inside,
                           hn::Gt(hn::Add(hn::Add(product(0), product(1)), product(2)), hn::Set(d, min_normal_cosine)));
          inside = cut_at(tree, list[i], p, position_[0] + v * kTileLanes, position_[1] + v * kTileLanes,
                          position_[2] + v * kTileLanes, inside);
        }
        t[v] = hn::IfThenElseZero(inside, kernel_profile_at<shape>(d, t[v]));
        // A mask is -1 where it is set.
        inside_count = hn::Sub(inside_count, hn::VecFromMask(di, hn::RebindMask(di, inside)));
      }
      add_color(p[7 * kBlockWidth], t, r);
      add_color(p[8 * kBlockWidth], t, g);
      add_color(p[9 * kBlockWidth], t, b);
    }
    for (std::size_t v = 0; v < kTileVectors; ++v) {
      hn::Store(r[v], d, sums_[0] + v * kTileLanes);
      hn::Store(g[v], d, sums_[1] + v * kTileLanes);
      hn::Store(b[v], d, sums_[2] + v * kTileLanes);
    }
    return static_cast<std::uint64_t>(hn::GetLane(hn::SumOfLanes(di, inside_count)));
  }

  /// Writes the sums to the run.
  HWY_INLINE void finish(const QueryRun& run) const {
    const TileTag d;
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < kGroupWidth; i += kTileLanes)
        hn::StoreU(hn::Load(d, sums_[c] + i), d, run.sum[c] + first_ + i);
  }

 private:
  /// Squares of the distances from the group's points to a photon.
  HWY_INLINE void square_distances(const float* photon, TileVector* out) const {
    const TileTag d;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const TileVector x = hn::Set(d, photon[axis * kBlockWidth]);
      for (std::size_t v = 0; v < kTileVectors; ++v) {
        const TileVector away = hn::Sub(x, hn::Load(d, position_[axis] + v * kTileLanes));
        out[v] = axis == 0 ? hn::Mul(away, away) : hn::MulAdd(away, away, out[v]);
      }
    }
  }
  static HWY_INLINE void add_color(float flux, const TileVector* weight, TileVector* sum) {
    const TileVector f = hn::Set(TileTag(), flux);
    for (std::size_t v = 0; v < kTileVectors; ++v) sum[v] = hn::MulAdd(weight[v], f, sum[v]);
  }

  std::size_t first_, valid_;
  alignas(64) float position_[3][kGroupWidth];
  alignas(64) float normal_[3][kGroupWidth];
  alignas(64) float sums_[3][kGroupWidth];
};

/// Sums the photons at the points of a run, group by group.
template <class Group>
class RunSummer {
 public:
  RunSummer(const BlockTree& tree, const QueryRun& run, BlockedScratch& scratch, BlockedCounts& counts,
            const GlossyPoints* glossy = nullptr)
      : tree_(tree), run_(run), scratch_(scratch), counts_(counts), glossy_(glossy) {}

  void run() {
    if (run_.count == 0) return;
    const std::size_t padded = (run_.count + kTileWidth - 1) / kTileWidth * kTileWidth;
    find_nodes(tree_, bounds_of(run_, 0, padded), scratch_);
    scratch_.blocks.resize(scratch_.nodes.size() * kBlockWidth + kBlockWidth);
    scratch_.photons.resize(kGroups * kListRoom);
    for (std::size_t first = 0; first < run_.count; first += kTileWidth) sum_tile(first);
  }

 private:
  /// Photons near some points of the tile, in the order of the tree: every point's sum is added in that order, whatever
  /// other points are in the call.
  struct List {
    std::uint32_t *first, *end;
    bool compares = false;  ///< whether to test normals and planes: some photon is undecided for some point
    bool full() const { return end - first > kListLength; }
  };

  void sum_tile(std::size_t first) {
    const SpreadBounds q(bounds_of(run_, first, kTileWidth), tree_.min_normal_cosine);
    std::uint32_t* end = scratch_.blocks.data();
    for (const std::uint32_t node : scratch_.nodes) append_children(tree_.level[0][node], q, node * kBlockWidth, end);
    const std::size_t groups = HWY_MIN(kGroups, (run_.count - first + kGroupWidth - 1) / kGroupWidth);
    for (std::size_t g = 0; g < groups; ++g) {
      groups_[g].start(run_, glossy_, first + g * kGroupWidth);
      std::uint32_t* const list = scratch_.photons.data() + g * kListRoom;
      lists_[g] = {list, list, false};
    }
    list_photons(first, groups, end);
    for (std::size_t g = 0; g < groups; ++g) {
      add(g);
      groups_[g].finish(run_);
    }
  }

  /// Tests the photons of the listed blocks against the bounds of each list's points, and lists those that may be in
  /// support. Reads photons once for all lists, because most are not in the caches.
  void list_photons(std::size_t first, std::size_t groups, const std::uint32_t* end) {
    const BlockTag d;
    const BlockVector rim = hn::Set(d, kRimMargin);
    SpreadBounds tests[kGroups];
    BlockVector sure_cosine[kGroups];
    for (std::size_t l = 0; l < groups; ++l) {
      const QueryBounds bounds = bounds_of(run_, first + l * kGroupWidth, kGroupWidth);
      tests[l] = SpreadBounds(bounds, tree_.min_normal_cosine);
      sure_cosine[l] = hn::Set(d, tree_.min_normal_cosine + bounds.spread + kNormalMargin);
    }
    for (const std::uint32_t* i = scratch_.blocks.data(); i != end; ++i) {
      if (end - i > kBlocksAhead) {
        const auto* ahead = reinterpret_cast<const char*>(&tree_.blocks[i[kBlocksAhead]]);
        for (std::size_t line = 0; line < offsetof(PhotonBlock, r); line += 64) __builtin_prefetch(ahead + line);
      }
      const PhotonBlock& block = tree_.blocks[*i];
      const BlockCuts* const cuts = tree_.cuts_of(*i);
      for (std::size_t lane = 0; lane < kBlockWidth; lane += hn::Lanes(d)) {
        const std::uint32_t place =
            *i * static_cast<std::uint32_t>(sizeof(PhotonBlock) / sizeof(float)) + static_cast<std::uint32_t>(lane);
        for (std::size_t l = 0; l < groups; ++l) {
          const SpreadBounds& q = tests[l];
          const auto gap = [&](const float* p, int axis) HWY_ATTR {
            const BlockVector v = hn::Load(d, p + lane);
            return hn::Sub(v, hn::Min(hn::Max(v, q.min[axis]), q.max[axis]));
          };
          const BlockVector x = gap(block.x, 0), y = gap(block.y, 1), z = gap(block.z, 2);
          const BlockVector t = hn::Mul(hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))),
                                        hn::Load(d, block.inverse_radius_squared + lane));
          const BlockVector cosine = hn::MulAdd(hn::Load(d, block.nx + lane), q.normal[0],
                                                hn::MulAdd(hn::Load(d, block.ny + lane), q.normal[1],
                                                           hn::Mul(hn::Load(d, block.nz + lane), q.normal[2])));
          BlockMask near = hn::And(hn::Lt(t, rim), hn::Gt(cosine, q.lowest_cosine));
          if (hn::AllFalse(d, near)) continue;
          BlockMask sure = hn::Gt(cosine, sure_cosine[l]);
          if (cuts) {
            const CutBounds cut = cut_bounds(block, *cuts, lane, q, near);
            near = hn::AndNot(cut.ends_before, near);
            if (hn::AllFalse(d, near)) continue;
            sure = hn::AndNot(cut.crosses, sure);
          }
          const bool compares = !hn::AllTrue(d, hn::Or(sure, hn::Not(near)));
          if (compares != lists_[l].compares) {
            add(l);
            lists_[l].compares = compares;
          }
          append_lanes(near, place, lists_[l].end);
        }
      }
      for (std::size_t l = 0; l < groups; ++l)
        if (lists_[l].full()) add(l);
    }
  }

  /// Processes one of the lists and empties it.
  void add(std::size_t l) {
    List& list = lists_[l];
    Group& group = groups_[l];
    const auto length = static_cast<std::size_t>(list.end - list.first);
    if (length == 0) return;
    list.end = list.first;
    counts_.evaluated += list.compares ? group.template add<true>(tree_, list.first, length)
                                       : group.template add<false>(tree_, list.first, length);
    counts_.tested += length * group.valid();
    counts_.steps += length * kTileVectors;
  }

  const BlockTree& tree_;
  const QueryRun& run_;
  BlockedScratch& scratch_;
  BlockedCounts& counts_;
  const GlossyPoints* glossy_;
  Group groups_[kGroups];
  List lists_[kGroups];
};

/// blocked_find().
template <KernelShape shape>
void find(const BlockTree& tree, const float position[3], const float normal[3], BlockedScratch& scratch,
          std::vector<BlockedPhoton>& found, BlockedCounts& counts) {
  QueryBounds bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.min[axis] = bounds.max[axis] = position[axis];
    bounds.normal[axis] = normal[axis];
  }
  bounds.spread = 0;
  found.clear();
  find_nodes(tree, bounds, scratch);
  const SpreadBounds q(bounds, tree.min_normal_cosine);
  scratch.blocks.resize(scratch.nodes.size() * kBlockWidth + kBlockWidth);
  std::uint32_t* end = scratch.blocks.data();
  for (const std::uint32_t node : scratch.nodes) append_children(tree.level[0][node], q, node * kBlockWidth, end);
  const auto blocks = static_cast<std::size_t>(end - scratch.blocks.data());
  counts.tested += blocks * kBlockWidth;
  const BlockTag d;
  alignas(64) float profiles[kBlockWidth];
  for (std::size_t i = 0; i < blocks; ++i) {
    const PhotonBlock& block = tree.blocks[scratch.blocks[i]];
    for (std::size_t lane = 0; lane < kBlockWidth; lane += hn::Lanes(d)) {
      const BlockVector x = hn::Sub(q.min[0], hn::Load(d, block.x + lane)),
                        y = hn::Sub(q.min[1], hn::Load(d, block.y + lane)),
                        z = hn::Sub(q.min[2], hn::Load(d, block.z + lane));
      const BlockVector t =
          hn::Mul(hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))), hn::Load(d, block.inverse_radius_squared + lane));
      const BlockVector cosine = hn::Add(hn::Add(hn::Mul(q.normal[0], hn::Load(d, block.nx + lane)),
                                                 hn::Mul(q.normal[1], hn::Load(d, block.ny + lane))),
                                         hn::Mul(q.normal[2], hn::Load(d, block.nz + lane)));
      BlockMask inside = hn::And(hn::Lt(t, hn::Set(d, 1.0f)), hn::Gt(cosine, hn::Set(d, tree.min_normal_cosine)));
      if (const BlockCuts* cuts = tree.cuts_of(scratch.blocks[i]))
        inside = hn::AndNot(cut_bounds(block, *cuts, lane, q, inside).ends_before, inside);
      if (hn::AllFalse(d, inside)) continue;
      hn::Store(kernel_profile_at<shape>(d, t), d, profiles);
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, inside, bits);
      for (std::size_t j = 0; j < hn::Lanes(d); ++j)
        if (bits[0] >> j & 1)
          found.push_back({static_cast<std::uint32_t>(scratch.blocks[i] * kBlockWidth + lane + j), profiles[j]});
    }
  }
  counts.evaluated += found.size();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
