#include "kernels/forward.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/forward.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "kernels/kernel_shape-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

/// A packet of kLanes query points, in as many registers as it needs on this machine.
template <int kLanes>
struct Packet {
  using D = hn::CappedTag<float, kLanes>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;
  static constexpr std::size_t kWidth = hn::MaxLanes(D());
  static constexpr std::size_t kRegisters = kLanes / kWidth;

  struct Active {
    M lanes[kRegisters];

    bool none() const {
      M all = lanes[0];
      for (std::size_t i = 1; i < kRegisters; ++i) all = hn::Or(all, lanes[i]);
      return hn::AllFalse(D(), all);
    }
    std::size_t count() const {
      std::size_t sum = 0;
      for (std::size_t i = 0; i < kRegisters; ++i) sum += hn::CountTrue(D(), lanes[i]);
      return sum;
    }
  };

  V position[3][kRegisters], normal[3][kRegisters];

  void load(const ForwardQueries& q, std::size_t first) {
    const D d;
    for (std::size_t i = 0; i < kRegisters; ++i) {
      const std::size_t at = first + i * kWidth;
      position[0][i] = hn::LoadU(d, q.x + at);
      position[1][i] = hn::LoadU(d, q.y + at);
      position[2][i] = hn::LoadU(d, q.z + at);
      normal[0][i] = hn::LoadU(d, q.normal_x + at);
      normal[1][i] = hn::LoadU(d, q.normal_y + at);
      normal[2][i] = hn::LoadU(d, q.normal_z + at);
    }
  }
  static Active first_lanes(std::size_t count) {
    Active active;
    for (std::size_t i = 0; i < kRegisters; ++i) {
      const std::size_t before = i * kWidth;
      active.lanes[i] = hn::FirstN(D(), count > before ? std::min(count - before, kWidth) : 0);
    }
    return active;
  }
};

/// Sums photons, for Lambertian query points.
template <int kLanes>
struct Sums {
  using P = Packet<kLanes>;
  typename P::V sum[3][P::kRegisters];

  Sums() {
    for (auto& channel : sum) {
      for (auto& v : channel) v = hn::Zero(typename P::D());
    }
  }
  void add(std::uint32_t, const ForwardCold& cold, std::size_t i, typename P::V weight, typename P::M) {
    const typename P::D d;
    for (int c = 0; c < 3; ++c) sum[c][i] = hn::MulAdd(weight, hn::Set(d, cold.flux[c]), sum[c][i]);
  }
};

/// Records pairs, for query points that are not Lambertian.
template <int kLanes>
struct Collected {
  using P = Packet<kLanes>;
  std::vector<ForwardPair>& pairs;
  std::size_t first;

  void add(std::uint32_t photon, const ForwardCold&, std::size_t i, typename P::V weight, typename P::M inside) {
    const typename P::D d;
    HWY_ALIGN float weights[P::kWidth];
    std::uint8_t bits[8] = {};
    hn::Store(weight, d, weights);
    hn::StoreMaskBits(d, inside, bits);
    for (std::size_t lane = 0; lane < P::kWidth; ++lane) {
      if (bits[lane / 8] >> (lane % 8) & 1) {
        pairs.push_back({static_cast<std::uint32_t>(first + i * P::kWidth + lane), photon, weights[lane]});
      }
    }
  }
};

/// "ShadeCurrentNode" of [SF07]: tests the true distance of a node's photon and shades it if it counts.
template <int kLanes, KernelShape shape, class Sink>
HWY_INLINE void shade(const ForwardTree& tree, const Packet<kLanes>& packet,
                      const typename Packet<kLanes>::Active& active, std::uint32_t node, Sink& sink,
                      ForwardCounts& counts) {
  using P = Packet<kLanes>;
  const typename P::D d;
  const ForwardHot& hot = tree.hot[node];
  const ForwardCold& cold = tree.cold[node];
  ++counts.shadings;
  counts.active += active.count();
  for (std::size_t i = 0; i < P::kRegisters; ++i) {
    const auto x = hn::Sub(packet.position[0][i], hn::Set(d, hot.x));
    const auto y = hn::Sub(packet.position[1][i], hn::Set(d, hot.y));
    const auto z = hn::Sub(packet.position[2][i], hn::Set(d, hot.z));
    const auto distance_squared = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
    const auto u = hn::Mul(distance_squared, hn::Set(d, hot.inverse_radius_squared));
    const auto near = hn::And(active.lanes[i], hn::Lt(u, hn::Set(d, 1.0f)));
    if (hn::AllFalse(d, near)) continue;
    const auto cosine = hn::MulAdd(packet.normal[0][i], hn::Set(d, cold.normal[0]),
                                   hn::MulAdd(packet.normal[1][i], hn::Set(d, cold.normal[1]),
                                              hn::Mul(packet.normal[2][i], hn::Set(d, cold.normal[2]))));
    const auto inside = hn::And(near, hn::Gt(cosine, hn::Set(d, tree.min_normal_cosine)));
    const std::size_t count = hn::CountTrue(d, inside);
    if (count == 0) continue;
    counts.operations += count;
    sink.add(node, cold, i, hn::IfThenElseZero(inside, kernel_profile_at<shape>(d, u)), inside);
  }
}

/// Traversal by one packet: pseudo-code of [SF07], section 5, with corrected signs, and with a separate reach for each
/// side of a plane and for the photon on it, because radii may differ between photons.
template <int kLanes, KernelShape shape, class Sink>
void walk(const ForwardTree& tree, const Packet<kLanes>& packet, typename Packet<kLanes>::Active active, Sink& sink,
          ForwardCounts& counts) {
  using P = Packet<kLanes>;
  using Active = typename P::Active;
  const typename P::D d;
  struct Pending {
    Active active;
    std::uint32_t node;
  };
  Pending stack[32];  // the tree is balanced, with fewer than 2^32 nodes
  int depth = 0;
  std::uint32_t node = 0;
  for (;;) {
    const ForwardNode at = tree.nodes[node];
    const std::uint32_t axis = at.split & ForwardNode::kAxisMask;
    bool descend = false;
    if (axis == ForwardNode::kLeaf) {
      shade<kLanes, shape>(tree, packet, active, node, sink, counts);
    } else {
      float split;
      std::memcpy(&split, &at.split, sizeof split);
      const auto plane = hn::Set(d, split);
      const ForwardReach reach =
          tree.reach ? tree.reach[node] : ForwardReach{tree.fixed_reach, tree.fixed_reach, tree.fixed_reach};
      const auto own = hn::Set(d, reach.own), from_right = hn::Set(d, reach.left), from_left = hn::Set(d, -reach.right);
      Active left, right, on_plane;
      for (std::size_t i = 0; i < P::kRegisters; ++i) {
        const auto distance = hn::Sub(packet.position[axis][i], plane);
        left.lanes[i] = hn::And(active.lanes[i], hn::Lt(distance, from_right));
        right.lanes[i] = hn::And(active.lanes[i], hn::Gt(distance, from_left));
        on_plane.lanes[i] = hn::And(active.lanes[i], hn::Lt(hn::Abs(distance), own));
      }
      if (!on_plane.none()) shade<kLanes, shape>(tree, packet, on_plane, node, sink, counts);
      if (at.right != 0 && !right.none()) stack[depth++] = {right, at.right};
      descend = !left.none();
      active = left;
      ++node;
    }
    if (descend) continue;
    if (depth == 0) return;
    --depth;
    active = stack[depth].active;
    node = stack[depth].node;
  }
}

/// Stores the first `count` lanes of a vector of sums.
template <class D, class V>
void add_lanes(D d, V sum, float* to, std::size_t count) {
  HWY_ALIGN float lanes[hn::MaxLanes(D())];
  hn::Store(sum, d, lanes);
  for (std::size_t i = 0; i < std::min(count, hn::MaxLanes(D())); ++i) to[i] += lanes[i];
}

template <int kLanes, KernelShape shape>
void gather_with(const ForwardTree& tree, const ForwardQueries& queries, float* const rgb[3], ForwardCounts& counts) {
  using P = Packet<kLanes>;
  P packet;
  for (std::size_t first = 0; first < queries.count; first += kLanes) {
    const std::size_t count = std::min<std::size_t>(queries.count - first, kLanes);
    packet.load(queries, first);
    Sums<kLanes> sums;
    walk<kLanes, shape>(tree, packet, P::first_lanes(count), sums, counts);
    for (int c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i * P::kWidth < count; ++i) {
        add_lanes(typename P::D(), sums.sum[c][i], rgb[c] + first + i * P::kWidth, count - i * P::kWidth);
      }
    }
  }
}

template <int kLanes, KernelShape shape>
void collect_with(const ForwardTree& tree, const ForwardQueries& queries, std::size_t first,
                  std::vector<ForwardPair>& pairs, ForwardCounts& counts) {
  using P = Packet<kLanes>;
  P packet;
  packet.load(queries, first);
  Collected<kLanes> collected{pairs, first};
  walk<kLanes, shape>(tree, packet, P::first_lanes(std::min<std::size_t>(queries.count - first, kLanes)), collected,
                      counts);
}

/// Calls work(lanes, shape) with both as compile-time constants.
template <class Work>
HWY_INLINE void dispatch(int lanes, KernelShape kernel, Work&& work) {
  with_kernel_shape(kernel, [&](auto shape) HWY_ATTR {
    if (lanes >= 16) return work(std::integral_constant<int, 16>(), shape);
    if (lanes >= 8) return work(std::integral_constant<int, 8>(), shape);
    if (lanes >= 4) return work(std::integral_constant<int, 4>(), shape);
    return work(std::integral_constant<int, 1>(), shape);
  });
}

void gather(const ForwardTree& tree, const ForwardQueries& queries, int lanes, float* const rgb[3],
            ForwardCounts& counts) {
  dispatch(lanes, tree.kernel, [&](auto width, auto shape) HWY_ATTR {
    gather_with<decltype(width)::value, decltype(shape)::value>(tree, queries, rgb, counts);
  });
}

void collect(const ForwardTree& tree, const ForwardQueries& queries, std::size_t first, int lanes,
             std::vector<ForwardPair>& pairs, ForwardCounts& counts) {
  dispatch(lanes, tree.kernel, [&](auto width, auto shape) HWY_ATTR {
    collect_with<decltype(width)::value, decltype(shape)::value>(tree, queries, first, pairs, counts);
  });
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(gather);
HWY_EXPORT(collect);
}  // namespace

void forward_gather(const ForwardTree& tree, const ForwardQueries& queries, int lanes, float* r, float* g, float* b,
                    ForwardCounts& counts) {
  if (tree.count == 0) return;
  float* const rgb[3] = {r, g, b};
  HWY_DYNAMIC_DISPATCH(gather)(tree, queries, lanes, rgb, counts);
}

void forward_collect(const ForwardTree& tree, const ForwardQueries& queries, std::size_t first, int lanes,
                     std::vector<ForwardPair>& pairs, ForwardCounts& counts) {
  if (tree.count == 0 || first >= queries.count) return;
  HWY_DYNAMIC_DISPATCH(collect)(tree, queries, first, lanes, pairs, counts);
}

}  // namespace glowworm
#endif  // HWY_ONCE
