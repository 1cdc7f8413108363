// The search of photon clusters for leaves in a tree of query points; compiled once for every instruction set.
#if defined(GLOWWORM_KERNELS_REVERSE_SEARCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLOWWORM_KERNELS_REVERSE_SEARCH_INL_H_
#undef GLOWWORM_KERNELS_REVERSE_SEARCH_INL_H_
#else
#define GLOWWORM_KERNELS_REVERSE_SEARCH_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <span>

#include "kernels/reverse.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kReversePadding>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using DI = hn::RebindToSigned<D>;
using DU = hn::RebindToUnsigned<D>;
constexpr std::size_t kWidth = hn::MaxLanes(D());

/// Photons that reach the bounds of a leaf, copied side by side, so that tests and sums read them from the first-level
/// cache.
struct Reached {
  static constexpr std::size_t kMaxCount = 256;
  static constexpr std::size_t kRoom = kMaxCount + kReversePadding;

  HWY_ALIGN float x[kRoom];
  float y[kRoom], z[kRoom], inverse_radius_squared[kRoom];
  float r[kRoom], g[kRoom], b[kRoom];
  std::uint32_t photons[kRoom];  ///< their indices in A_P
  std::size_t count = 0;
  bool check_normals = false;  ///< whether the normal of some photon matches only some of the points
};

/// Appends photons `first` + i of A_P for all set lanes i; returns their number.
template <bool kColors>
HWY_INLINE std::size_t append(const ReversePhotons& photons, std::uint32_t first, M lanes, Reached& reached,
                              std::size_t to) {
  const D d;
#if HWY_TARGET <= HWY_AVX3
  // Stores whole vectors; the next call overwrites lanes after the photons found.
  const auto put = [&](const float* from, float* field)
                       HWY_ATTR { hn::StoreU(hn::Compress(hn::LoadU(d, from + first), lanes), d, field + to); };
  // Iota() of Highway 1.0 goes through memory unless its argument is a constant.
  const DU du;
  const auto places = hn::Add(hn::Iota(du, 0), hn::Set(du, first));
  hn::StoreU(hn::Compress(places, hn::RebindMask(du, lanes)), du, reached.photons + to);
  const std::size_t count = hn::CountTrue(d, lanes);
#else
  // Compress() of Highway 1.0 copies its table to the stack each time.
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, lanes, bytes);
  std::size_t count = 0;
  for (std::uint32_t bits = bytes[0] | std::uint32_t{bytes[1]} << 8; bits != 0; bits &= bits - 1)
    reached.photons[to + count++] = first + static_cast<std::uint32_t>(std::countr_zero(bits));
  const auto put = [&](const float* from, float* field) HWY_ATTR {
    for (std::size_t i = to; i < to + count; ++i) field[i] = from[reached.photons[i]];
  };
#endif
  put(photons.x, reached.x);
  put(photons.y, reached.y);
  put(photons.z, reached.z);
  put(photons.inverse_radius_squared, reached.inverse_radius_squared);
  if (kColors) {
    put(photons.r, reached.r);
    put(photons.g, reached.g);
    put(photons.b, reached.b);
  }
  return count;
}

/// The bounds of a leaf, broadcast to all lanes.
struct LeafBox {
  V min[3], max[3], normal[3], spread;

  explicit LeafBox(const ReverseLeafBounds& bounds) {
    const D d;
    for (int axis = 0; axis < 3; ++axis) {
      min[axis] = hn::Set(d, bounds.min[axis]);
      max[axis] = hn::Set(d, bounds.max[axis]);
      normal[axis] = hn::Set(d, bounds.normal[axis]);
    }
    spread = hn::Set(d, bounds.spread);
  }
  HWY_INLINE V outside(V p, int axis) const {
    return hn::Max(hn::Zero(D()), hn::Max(hn::Sub(min[axis], p), hn::Sub(p, max[axis])));
  }
};

/// Appends the photons of a cluster that reach the box. It uses the same arithmetic as the test of pairs; each step is
/// monotone, so rounding loses no pair inside the support.
template <bool kColors>
HWY_INLINE void accept(const LeafBox& box, const ReversePhotons& photons, const ReverseCluster& cluster,
                       Reached& reached) {
  const D d;
  const V limit = hn::Set(d, photons.min_normal_cosine);
  M unsure = hn::FirstN(d, 0);
  std::size_t count = reached.count;
  for (std::size_t i = 0; i < cluster.count; i += kWidth) {
    const std::size_t at = cluster.first + i;
    const V x = box.outside(hn::LoadU(d, photons.x + at), 0), y = box.outside(hn::LoadU(d, photons.y + at), 1),
            z = box.outside(hn::LoadU(d, photons.z + at), 2);
    const V u =
        hn::Mul(hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))), hn::LoadU(d, photons.inverse_radius_squared + at));
    const M near = hn::And(hn::FirstN(d, cluster.count - i), hn::Lt(u, hn::Set(d, 1.0f)));
    if (hn::AllFalse(d, near)) continue;
    const V cosine = hn::MulAdd(hn::LoadU(d, photons.normal_x + at), box.normal[0],
                                hn::MulAdd(hn::LoadU(d, photons.normal_y + at), box.normal[1],
                                           hn::Mul(hn::LoadU(d, photons.normal_z + at), box.normal[2])));
    const M found = hn::And(near, hn::Gt(hn::Add(cosine, box.spread), limit));
    unsure = hn::Or(unsure, hn::And(found, hn::Le(hn::Sub(cosine, box.spread), limit)));
    count += append<kColors>(photons, static_cast<std::uint32_t>(at), found, reached, count);
  }
  reached.count = count;
  reached.check_normals = reached.check_normals || !hn::AllFalse(d, unsure);
}

HWY_INLINE bool overlap(const ReverseCluster& cluster, const ReverseLeafBounds& box) {
  bool apart = false;
  for (int axis = 0; axis < 3; ++axis)
    apart |= (cluster.min[axis] > box.max[axis]) | (cluster.max[axis] < box.min[axis]);
  return !apart;
}

/// Passes the photons of some clusters that reach a leaf to the sink.
template <class S>
void visit_leaf(const ReverseSubtreeView& part, std::uint32_t at, const ReversePhotons& photons,
                const ReverseCluster* clusters, const std::uint8_t* list, std::size_t count, S& sink,
                Reached& reached) {
  const auto give = [&]() HWY_ATTR {
    if (reached.check_normals) {
      sink.template leaf<true>(part.nodes[at], reached);
    } else if (reached.count > 0) {
      sink.template leaf<false>(part.nodes[at], reached);
    }
    reached.count = 0;
    reached.check_normals = false;
  };
  const ReverseLeafBounds& bounds = part.bounds[at - part.root];
  const LeafBox box(bounds);
  for (std::size_t i = 0; i < count; ++i) {
    const ReverseCluster& cluster = clusters[list[i]];
    if (!overlap(cluster, bounds)) continue;
    if (reached.count + cluster.count > Reached::kMaxCount) give();
    accept<S::kColors>(box, photons, cluster, reached);
  }
  give();
}

// Clusters that descend the tree together: as many as a byte can index.
constexpr std::size_t kBatch = 256;

/// Descends the tree with a batch of clusters. Each node has a list of the clusters that reach its cell, so a leaf
/// processes all its photons at once.
template <class S>
void search_batch(const ReverseSubtreeView& part, const ReversePhotons& photons,
                  std::span<const ReverseCluster> clusters, S& sink, ReverseCounts& counts) {
  // The lists of pending nodes on the path to the current node, and its own list, one after another.
  std::uint8_t lists[(ReverseNode::kMaxDepth + 2) * kBatch];
  struct Pending {
    std::uint32_t node, first, count;
  };
  Pending stack[ReverseNode::kMaxDepth];
  int depth = 0;
  Reached reached;
  for (std::size_t i = 0; i < clusters.size(); ++i) lists[i] = static_cast<std::uint8_t>(i);
  Pending now{part.root, 0, static_cast<std::uint32_t>(clusters.size())};
  for (;;) {
    const ReverseNode node = part.nodes[now.node];
    const std::uint8_t* list = lists + now.first;
    counts.nodes += now.count;
    if (node.is_leaf()) {
      if (now.count > 0) visit_leaf(part, now.node, photons, clusters.data(), list, now.count, sink, reached);
      if (depth == 0) return;
      now = stack[--depth];
      continue;
    }
    // The list of the right child replaces the node's; the list of the left child follows it.
    const int axis = node.axis();
    const float split = node.split();
    std::uint8_t *right = lists + now.first, *left = lists + now.first + now.count;
    const std::uint8_t* const left_begin = left;
    std::uint32_t right_count = 0;
    for (std::uint32_t i = 0; i < now.count; ++i) {
      const std::uint8_t cluster = list[i];
      const bool is_left = clusters[cluster].min[axis] <= split, is_right = clusters[cluster].max[axis] >= split;
      right[right_count] = cluster;
      *left = cluster;
      right_count += is_right;
      left += is_left;
    }
    const auto left_count = static_cast<std::uint32_t>(left - left_begin);
    if (left_count > 0) {
      if (right_count > 0) stack[depth++] = {node.right(), now.first, right_count};
      now = {now.node + 1, now.first + now.count, left_count};
    } else if (right_count > 0) {
      now = {node.right(), now.first, right_count};
    } else {
      if (depth == 0) return;
      now = stack[--depth];
    }
  }
}

/// Visits the leaves that the clusters reach.
template <class S>
void search(const ReverseSubtreeView& part, const ReversePhotons& photons, std::span<const ReverseCluster> clusters,
            S&& sink, ReverseCounts& counts) {
  for (std::size_t first = 0; first < clusters.size(); first += kBatch)
    search_batch(part, photons, clusters.subspan(first, std::min(kBatch, clusters.size() - first)), sink, counts);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
