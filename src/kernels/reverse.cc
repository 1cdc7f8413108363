#include "kernels/reverse.h"

#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/reverse.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "kernels/kernel_shape-inl.h"
#include "kernels/reverse_search-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

/// A vector of reverse photons.
struct Lanes {
  V x, y, z, normal_x, normal_y, normal_z;

  /// Lanes after the end of the leaf are infinitely far away.
  template <bool kNormals>
  HWY_INLINE void load(const float* leaf, std::size_t count, std::size_t at) {
    const D d;
    x = hn::IfThenElse(hn::FirstN(d, count - at), hn::LoadU(d, leaf + at), hn::Inf(d));
    y = hn::LoadU(d, leaf + count + at);
    z = hn::LoadU(d, leaf + 2 * count + at);
    normal_x = kNormals ? hn::LoadU(d, leaf + 3 * count + at) : x;
    normal_y = kNormals ? hn::LoadU(d, leaf + 4 * count + at) : x;
    normal_z = kNormals ? hn::LoadU(d, leaf + 5 * count + at) : x;
  }

  /// The lanes inside the support of photon i (an index into the photons that reach the leaf) with matching normals.
  /// Sets u to (distance / radius)^2.
  template <bool kNormals>
  HWY_INLINE M inside(const ReversePhotons& photons, const Reached& reached, std::size_t i, V& u) const {
    const D d;
    const V dx = hn::Sub(x, hn::Set(d, reached.x[i])), dy = hn::Sub(y, hn::Set(d, reached.y[i])),
            dz = hn::Sub(z, hn::Set(d, reached.z[i]));
    u = hn::Mul(hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz))), hn::Set(d, reached.inverse_radius_squared[i]));
    const M near = hn::Lt(u, hn::Set(d, 1.0f));
    if (!kNormals) return near;
    const std::uint32_t j = reached.photons[i];
    const V cosine = hn::MulAdd(
        normal_x, hn::Set(d, photons.normal_x[j]),
        hn::MulAdd(normal_y, hn::Set(d, photons.normal_y[j]), hn::Mul(normal_z, hn::Set(d, photons.normal_z[j]))));
    return hn::And(near, hn::Gt(cosine, hn::Set(d, photons.min_normal_cosine)));
  }
};

/// Adds photons to the sums of a vector of reverse photons.
template <KernelShape shape>
struct Sums {
  V r, g, b;

  HWY_INLINE void load(const float* sums, std::size_t count, std::size_t at) {
    const D d;
    r = hn::LoadU(d, sums + at);
    g = hn::LoadU(d, sums + count + at);
    b = hn::LoadU(d, sums + 2 * count + at);
  }
  HWY_INLINE void store(float* sums, std::size_t count, std::size_t at) const {
    const D d;
    const M valid = hn::FirstN(d, count - at);
    hn::BlendedStore(r, valid, d, sums + at);
    hn::BlendedStore(g, valid, d, sums + count + at);
    hn::BlendedStore(b, valid, d, sums + 2 * count + at);
  }
  HWY_INLINE void add(const Reached& reached, std::size_t i, V u, M inside) {
    const D d;
    const V weight = hn::IfThenElseZero(inside, kernel_profile_at<shape>(D(), u));
    r = hn::MulAdd(weight, hn::Set(d, reached.r[i]), r);
    g = hn::MulAdd(weight, hn::Set(d, reached.g[i]), g);
    b = hn::MulAdd(weight, hn::Set(d, reached.b[i]), b);
  }
};

/// Counts lanes in vector registers.
struct LaneCounter {
  hn::Vec<DI> minus;

  HWY_INLINE LaneCounter() : minus(hn::Zero(DI())) {}
  HWY_INLINE void add(M lanes) {
    const DI d;
    minus = hn::Add(minus, hn::VecFromMask(d, hn::RebindMask(d, lanes)));
  }
  HWY_INLINE std::uint64_t count() const {
    const DI d;
    return static_cast<std::uint64_t>(-std::int64_t{hn::GetLane(hn::SumOfLanes(d, minus))});
  }
};

/// Calls run(number of vectors, as a constant; first point) for all vectors of a leaf of `count` points. Several
/// vectors share the loads of a photon's data, and their latencies overlap.
template <std::size_t kMaxVectors, class Run>
HWY_INLINE void for_vectors(std::size_t count, Run&& run) {
  for (std::size_t at = 0; at < count;) {
    const std::size_t left = (count - at + kWidth - 1) / kWidth;
    if (kMaxVectors >= 3 && left >= 3 && left != 4) {
      run(std::integral_constant<std::size_t, 3>(), at);
      at += 3 * kWidth;
    } else if (left >= 2) {
      run(std::integral_constant<std::size_t, 2>(), at);
      at += 2 * kWidth;
    } else {
      run(std::integral_constant<std::size_t, 1>(), at);
      at += kWidth;
    }
  }
}
// Vectors per call, limited by the number of registers.
constexpr std::size_t kVectors = kWidth >= 16 ? 3 : 2;

/// Sink of reverse_sum(): adds to the leaf's entries of A_W.
template <KernelShape shape>
struct Sink {
  static constexpr bool kColors = true;
  const ReverseSubtreeView& part;
  const ReversePhotons& photons;
  ReverseCounts& counts;

  template <bool kNormals>
  void leaf(const ReverseNode& node, const Reached& reached) {
    const std::size_t count = node.count();
    const std::size_t first = node.first() - part.first_point;
    const float* points = part.points + first * kReverseFields;
    float* sums = part.sums + first * kReverseSums;
    for_vectors<kNormals ? 2 : kVectors>(count, [&](auto vectors, std::size_t at) HWY_ATTR {
      constexpr std::size_t kCount = decltype(vectors)::value;
      Lanes lanes[kCount];
      Sums<shape> lane_sums[kCount];
      LaneCounter operations;
      for (std::size_t v = 0; v < kCount; ++v) {
        lanes[v].template load<kNormals>(points, count, at + v * kWidth);
        lane_sums[v].load(sums, count, at + v * kWidth);
      }
      for (std::size_t i = 0; i < reached.count; ++i) {
        for (std::size_t v = 0; v < kCount; ++v) {
          V u;
          const M inside = lanes[v].template inside<kNormals>(photons, reached, i, u);
          operations.add(inside);
          lane_sums[v].add(reached, i, u, inside);
        }
      }
      for (std::size_t v = 0; v < kCount; ++v) lane_sums[v].store(sums, count, at + v * kWidth);
      counts.operations += operations.count();
      counts.steps += kCount * reached.count;
    });
    counts.tested += reached.count * count;
  }
};

/// Sink of reverse_collect(): appends to a list of pairs.
template <KernelShape shape>
struct Collector {
  static constexpr bool kColors = false;
  const ReverseSubtreeView& part;
  const ReversePhotons& photons;
  ReverseCounts& counts;
  std::vector<ReversePair>& pairs;

  template <bool kNormals>
  void leaf(const ReverseNode& node, const Reached& reached) {
    const D d;
    const std::size_t count = node.count();
    const float* points = part.points + (node.first() - part.first_point) * kReverseFields;
    for (std::size_t at = 0; at < count; at += kWidth) {
      Lanes p;
      p.load<kNormals>(points, count, at);
      for (std::size_t i = 0; i < reached.count; ++i) {
        V u;
        const M inside = p.inside<kNormals>(photons, reached, i, u);
        if (hn::AllFalse(d, inside)) continue;
        HWY_ALIGN float profile[kWidth];
        hn::Store(kernel_profile_at<shape>(D(), u), d, profile);
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, inside, bytes);
        for (std::uint32_t bits = bytes[0] | std::uint32_t{bytes[1]} << 8; bits != 0; bits &= bits - 1) {
          const auto lane = static_cast<std::uint32_t>(std::countr_zero(bits));
          pairs.push_back({node.first() + static_cast<std::uint32_t>(at) + lane, reached.photons[i], profile[lane]});
          ++counts.operations;
        }
      }
      counts.steps += reached.count;
    }
    counts.tested += reached.count * count;
  }
};

void sum(const ReverseSubtreeView& part, const ReversePhotons& photons, std::span<const ReverseCluster> clusters,
         ReverseCounts& counts) {
  with_kernel_shape(photons.kernel, [&](auto shape) HWY_ATTR {
    search(part, photons, clusters, Sink<decltype(shape)::value>{part, photons, counts}, counts);
  });
}

void collect(const ReverseSubtreeView& part, const ReversePhotons& photons, std::span<const ReverseCluster> clusters,
             std::vector<ReversePair>& pairs, ReverseCounts& counts) {
  with_kernel_shape(photons.kernel, [&](auto shape) HWY_ATTR {
    search(part, photons, clusters, Collector<decltype(shape)::value>{part, photons, counts, pairs}, counts);
  });
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(sum);
HWY_EXPORT(collect);
}  // namespace

void reverse_sum(const ReverseSubtreeView& part, const ReversePhotons& photons,
                 std::span<const ReverseCluster> clusters, ReverseCounts& counts) {
  HWY_DYNAMIC_DISPATCH(sum)(part, photons, clusters, counts);
}

void reverse_collect(const ReverseSubtreeView& part, const ReversePhotons& photons,
                     std::span<const ReverseCluster> clusters, std::vector<ReversePair>& pairs, ReverseCounts& counts) {
  HWY_DYNAMIC_DISPATCH(collect)(part, photons, clusters, pairs, counts);
}

}  // namespace glowworm
#endif  // HWY_ONCE
