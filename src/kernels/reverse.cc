#include "kernels/reverse.h"

#include <bit>

// The searches keep vectors in structures, whose size must be known.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/reverse.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "kernels/glossy-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kReversePadding>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr std::size_t kWidth = hn::MaxLanes(D());

// Profiles of the kernels: K over its norm from u = (distance / radius)^2, where that is below 1.
struct Box {
  static V profile(V) { return hn::Set(D(), 1.0f); }
};
struct Cone {
  static V profile(V u) { return hn::Sub(hn::Set(D(), 1.0f), hn::Sqrt(u)); }
};
struct Epanechnikov {
  static V profile(V u) { return hn::Sub(hn::Set(D(), 1.0f), u); }
};
struct Gaussian {
  static V profile(V u) {
    // Lanes outside the support may hold anything; the exponential is asked for its own range alone.
    return hn::Exp(D(), hn::Mul(hn::Min(u, hn::Set(D(), 1.0f)), hn::Set(D(), -4.5f)));
  }
};

/// Photons of a cluster that reach into the bounds of a leaf.
struct Accepted {
  std::uint32_t photons[ReverseCluster::kMaxCount];
  std::size_t count = 0;
  bool check_normals = false;  ///< of some photon the normal may match some points and others not
};

/// Which photons of the cluster reach into the box, by the same arithmetic as that of pairs: each step of it is
/// monotone, so that no pair within the support is lost to rounding.
Accepted accept(const ReverseLeafBounds& box, const ReversePhotons& photons, const ReverseCluster& cluster) {
  const D d;
  Accepted accepted;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const V limit = hn::Set(d, photons.min_normal_cosine), spread = hn::Set(d, box.spread);
  M unsure = hn::FirstN(d, 0);
  const auto outside = [&](const float* position, int axis, std::size_t at) HWY_ATTR {
    const V p = hn::LoadU(d, position + at);
    const V below = hn::Sub(hn::Set(d, box.min[axis]), p), above = hn::Sub(p, hn::Set(d, box.max[axis]));
    return hn::Max(zero, hn::Max(below, above));
  };
  for (std::size_t i = 0; i < cluster.count; i += kWidth) {
    const std::size_t at = cluster.first + i;
    const V x = outside(photons.x, 0, at), y = outside(photons.y, 1, at), z = outside(photons.z, 2, at);
    const V distance_squared = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
    const V u = hn::Mul(distance_squared, hn::LoadU(d, photons.inverse_radius_squared + at));
    const V cosine = hn::MulAdd(hn::LoadU(d, photons.normal_x + at), hn::Set(d, box.normal[0]),
                                hn::MulAdd(hn::LoadU(d, photons.normal_y + at), hn::Set(d, box.normal[1]),
                                           hn::Mul(hn::LoadU(d, photons.normal_z + at), hn::Set(d, box.normal[2]))));
    const M near = hn::And(hn::FirstN(d, cluster.count - i), hn::Lt(u, one));
    const M found = hn::And(near, hn::Gt(hn::Add(cosine, spread), limit));
    if (hn::AllFalse(d, found)) continue;
    unsure = hn::Or(unsure, hn::And(found, hn::Le(hn::Sub(cosine, spread), limit)));
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, found, bytes);
    for (std::uint32_t bits = bytes[0] | std::uint32_t{bytes[1]} << 8; bits != 0; bits &= bits - 1) {
      accepted.photons[accepted.count++] =
          static_cast<std::uint32_t>(at) + static_cast<std::uint32_t>(std::countr_zero(bits));
    }
  }
  accepted.check_normals = !hn::AllFalse(d, unsure);
  return accepted;
}

/// A vector of reverse photons.
struct Lanes {
  V x, y, z, normal_x, normal_y, normal_z;

  template <bool kNormals>
  void load(const float* leaf, std::size_t count, std::size_t at) {
    const D d;
    x = hn::LoadU(d, leaf + at);
    y = hn::LoadU(d, leaf + count + at);
    z = hn::LoadU(d, leaf + 2 * count + at);
    normal_x = kNormals ? hn::LoadU(d, leaf + 3 * count + at) : x;
    normal_y = kNormals ? hn::LoadU(d, leaf + 4 * count + at) : x;
    normal_z = kNormals ? hn::LoadU(d, leaf + 5 * count + at) : x;
  }

  /// Lanes inside the support of a photon, of matching normal; u: (distance / radius)^2.
  template <bool kNormals>
  HWY_INLINE M inside(const ReversePhotons& photons, std::uint32_t j, V& u) const {
    const D d;
    const V dx = hn::Sub(x, hn::Set(d, photons.x[j])), dy = hn::Sub(y, hn::Set(d, photons.y[j])),
            dz = hn::Sub(z, hn::Set(d, photons.z[j]));
    u = hn::Mul(hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz))), hn::Set(d, photons.inverse_radius_squared[j]));
    const M near = hn::Lt(u, hn::Set(d, 1.0f));
    if (!kNormals) return near;
    const V cosine = hn::MulAdd(
        normal_x, hn::Set(d, photons.normal_x[j]),
        hn::MulAdd(normal_y, hn::Set(d, photons.normal_y[j]), hn::Mul(normal_z, hn::Set(d, photons.normal_z[j]))));
    return hn::And(near, hn::Gt(cosine, hn::Set(d, photons.min_normal_cosine)));
  }
};

/// Adds photons to the sums of a vector of reverse photons.
template <class Kernel>
struct Sums {
  V r, g, b;

  void load(const float* sums, std::size_t count, std::size_t at) {
    const D d;
    r = hn::LoadU(d, sums + at);
    g = hn::LoadU(d, sums + count + at);
    b = hn::LoadU(d, sums + 2 * count + at);
  }
  void store(float* sums, std::size_t count, std::size_t at, M valid) const {
    const D d;
    hn::BlendedStore(r, valid, d, sums + at);
    hn::BlendedStore(g, valid, d, sums + count + at);
    hn::BlendedStore(b, valid, d, sums + 2 * count + at);
  }
  HWY_INLINE void add(const ReversePhotons& photons, std::uint32_t j, V u, M inside) {
    const D d;
    const V weight = hn::IfThenElseZero(inside, Kernel::profile(u));
    r = hn::MulAdd(weight, hn::Set(d, photons.r[j]), r);
    g = hn::MulAdd(weight, hn::Set(d, photons.g[j]), g);
    b = hn::MulAdd(weight, hn::Set(d, photons.b[j]), b);
  }
};

/// Where reverse_sum() puts what it finds: the leaf's entries of A_W.
template <class Kernel>
struct Sink {
  const ReverseSubtreeView& part;
  const ReversePhotons& photons;
  ReverseCounts& counts;

  template <bool kNormals>
  void leaf(const ReverseNode& node, std::uint32_t, const Accepted& accepted) {
    const D d;
    const std::size_t count = node.count();
    const std::size_t first = node.first() - part.first_point;
    const float* points = part.points + first * kReverseFields;
    float* sums = part.sums + first * kReverseSums;
    std::size_t at = 0;
    std::uint64_t operations = 0;
    // Two vectors at once share the photon's data.
    for (; at + kWidth < count; at += 2 * kWidth) {
      const M valid = hn::FirstN(d, count - at - kWidth);
      Lanes p, q;
      Sums<Kernel> p_sums, q_sums;
      p.load<kNormals>(points, count, at);
      q.load<kNormals>(points, count, at + kWidth);
      p_sums.load(sums, count, at);
      q_sums.load(sums, count, at + kWidth);
      for (std::size_t i = 0; i < accepted.count; ++i) {
        const std::uint32_t j = accepted.photons[i];
        V u, v;
        const M p_inside = p.inside<kNormals>(photons, j, u);
        const M q_inside = hn::And(valid, q.inside<kNormals>(photons, j, v));
        operations += hn::CountTrue(d, p_inside) + hn::CountTrue(d, q_inside);
        p_sums.add(photons, j, u, p_inside);
        q_sums.add(photons, j, v, q_inside);
      }
      p_sums.store(sums, count, at, hn::FirstN(d, kWidth));
      q_sums.store(sums, count, at + kWidth, valid);
      counts.steps += 2 * accepted.count;
    }
    if (at < count) {
      const M valid = hn::FirstN(d, count - at);
      Lanes p;
      Sums<Kernel> p_sums;
      p.load<kNormals>(points, count, at);
      p_sums.load(sums, count, at);
      for (std::size_t i = 0; i < accepted.count; ++i) {
        V u;
        const M inside = hn::And(valid, p.inside<kNormals>(photons, accepted.photons[i], u));
        operations += hn::CountTrue(d, inside);
        p_sums.add(photons, accepted.photons[i], u, inside);
      }
      p_sums.store(sums, count, at, valid);
      counts.steps += accepted.count;
    }
    counts.tested += accepted.count * count;
    counts.operations += operations;
  }
};

/// Calls visit(first point of a vector, photon, u of the vector's points, those within the photon's kernel) for every
/// vector of a leaf and every photon accepted.
template <bool kNormals, class Visit>
HWY_INLINE void visit_pairs(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseNode& node,
                            const Accepted& accepted, ReverseCounts& counts, Visit&& visit) {
  const D d;
  const std::size_t count = node.count();
  const float* points = part.points + (node.first() - part.first_point) * kReverseFields;
  for (std::size_t at = 0; at < count; at += kWidth) {
    const M valid = hn::FirstN(d, count - at);
    Lanes p;
    p.load<kNormals>(points, count, at);
    for (std::size_t i = 0; i < accepted.count; ++i) {
      V u;
      const M inside = p.inside<kNormals>(photons, accepted.photons[i], u);
      visit(at, accepted.photons[i], u, hn::And(valid, inside));
    }
    counts.steps += accepted.count;
  }
  counts.tested += accepted.count * count;
}

/// Where reverse_sum_glossy() puts what it finds: the leaf's entries of A_W.
template <class Kernel, GlossyModel model>
struct GlossySink {
  const ReverseSubtreeView& part;
  const ReversePhotons& photons;
  const ReverseGlossy& glossy;
  ReverseCounts& counts;

  template <bool kNormals>
  void leaf(const ReverseNode& node, std::uint32_t index, const Accepted& accepted) {
    const D d;
    const std::size_t count = node.count();
    const GlossyPoints points{glossy.fields + glossy.leaf[index - part.root], reverse_glossy_stride(count),
                              glossy.tables, model};
    float* sums = part.sums + (node.first() - part.first_point) * kReverseSums;
    visit_pairs<kNormals>(
        part, photons, node, accepted, counts, [&](std::size_t at, std::uint32_t j, V u, M inside) HWY_ATTR {
          if (hn::AllFalse(d, inside)) return;
          counts.operations += hn::CountTrue(d, inside);
          const V weight = hn::IfThenElseZero(inside, Kernel::profile(u));
          const GlossyValue<D> f = glossy_value<model>(d, points, at, photons.directions + 3 * std::size_t{j});
          const auto add = [&](std::size_t channel, float flux, V value) HWY_ATTR {
            // The weight is 0 in all lanes that must not change, those behind the leaf among them; a store by mask
            // would take longer than all the rest.
            float* sum = sums + channel * count + at;
            hn::StoreU(hn::MulAdd(hn::Mul(weight, hn::Set(d, flux)), value, hn::LoadU(d, sum)), d, sum);
          };
          add(0, photons.r[j], f.r);
          add(1, photons.g[j], f.g);
          add(2, photons.b[j], f.b);
        });
  }
};

/// Where reverse_collect() puts what it finds: a list of pairs.
template <class Kernel>
struct Collector {
  const ReverseSubtreeView& part;
  const ReversePhotons& photons;
  ReverseCounts& counts;
  std::vector<ReversePair>& pairs;

  template <bool kNormals>
  void leaf(const ReverseNode& node, std::uint32_t, const Accepted& accepted) {
    const D d;
    visit_pairs<kNormals>(
        part, photons, node, accepted, counts, [&](std::size_t at, std::uint32_t photon, V u, M inside) HWY_ATTR {
          if (hn::AllFalse(d, inside)) return;
          HWY_ALIGN float profile[kWidth];
          hn::Store(Kernel::profile(u), d, profile);
          std::uint8_t bytes[8] = {};
          hn::StoreMaskBits(d, inside, bytes);
          for (std::uint32_t bits = bytes[0] | std::uint32_t{bytes[1]} << 8; bits != 0; bits &= bits - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(bits));
            pairs.push_back({node.first() + static_cast<std::uint32_t>(at) + lane, photon, profile[lane]});
            ++counts.operations;
          }
        });
  }
};

/// Where reverse_count() puts what it finds: nowhere.
struct Counter {
  const ReverseSubtreeView& part;
  const ReversePhotons& photons;
  ReverseCounts& counts;

  template <bool kNormals>
  void leaf(const ReverseNode& node, std::uint32_t, const Accepted& accepted) {
    const D d;
    visit_pairs<kNormals>(part, photons, node, accepted, counts, [&](std::size_t, std::uint32_t, V, M inside) HWY_ATTR {
      counts.operations += hn::CountTrue(d, inside);
    });
  }
};

/// Visits the leaves that the cluster reaches, from left to right.
template <class S>
void search(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster, S&& sink,
            ReverseCounts& counts) {
  // One way down for the sphere around the cluster, as far as it lies on one side of the planes.
  std::uint32_t at = part.root;
  while (!part.nodes[at].is_leaf()) {
    const ReverseNode node = part.nodes[at];
    const float distance = cluster.center[node.axis()] - node.split();
    if (distance < -cluster.radius) {
      ++at;
    } else if (distance > cluster.radius) {
      at = node.right();
    } else {
      break;
    }
    ++counts.nodes;
  }
  // From there on the box around the cluster, which is tighter where photons lie on one plane.
  std::uint32_t stack[ReverseNode::kMaxDepth];
  int depth = 0;
  for (;;) {
    const ReverseNode node = part.nodes[at];
    ++counts.nodes;
    if (!node.is_leaf()) {
      const int axis = node.axis();
      const float split = node.split();
      const bool left = cluster.min[axis] <= split, right = cluster.max[axis] >= split;
      if (left && right) stack[depth++] = node.right();
      if (left || right) {
        at = left ? at + 1 : node.right();
        continue;
      }
    } else {
      const Accepted accepted = accept(part.bounds[at - part.root], photons, cluster);
      if (accepted.check_normals) {
        sink.template leaf<true>(node, at, accepted);
      } else if (accepted.count > 0) {
        sink.template leaf<false>(node, at, accepted);
      }
    }
    if (depth == 0) return;
    at = stack[--depth];
  }
}

void sum(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster,
         ReverseCounts& counts) {
  switch (photons.kernel) {
    case ReverseKernel::box:
      return search(part, photons, cluster, Sink<Box>{part, photons, counts}, counts);
    case ReverseKernel::cone:
      return search(part, photons, cluster, Sink<Cone>{part, photons, counts}, counts);
    case ReverseKernel::epanechnikov:
      return search(part, photons, cluster, Sink<Epanechnikov>{part, photons, counts}, counts);
    case ReverseKernel::gaussian:
      return search(part, photons, cluster, Sink<Gaussian>{part, photons, counts}, counts);
  }
}

template <GlossyModel model>
void sum_of_model(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster,
                  const ReverseGlossy& glossy, ReverseCounts& counts) {
  switch (photons.kernel) {
    case ReverseKernel::box:
      return search(part, photons, cluster, GlossySink<Box, model>{part, photons, glossy, counts}, counts);
    case ReverseKernel::cone:
      return search(part, photons, cluster, GlossySink<Cone, model>{part, photons, glossy, counts}, counts);
    case ReverseKernel::epanechnikov:
      return search(part, photons, cluster, GlossySink<Epanechnikov, model>{part, photons, glossy, counts}, counts);
    case ReverseKernel::gaussian:
      return search(part, photons, cluster, GlossySink<Gaussian, model>{part, photons, glossy, counts}, counts);
  }
}

void sum_glossy(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster,
                const ReverseGlossy& glossy, ReverseCounts& counts) {
  switch (glossy.model) {
    case GlossyModel::coated:
      return sum_of_model<GlossyModel::coated>(part, photons, cluster, glossy, counts);
    case GlossyModel::conductor:
      return sum_of_model<GlossyModel::conductor>(part, photons, cluster, glossy, counts);
    case GlossyModel::schlick:
      return sum_of_model<GlossyModel::schlick>(part, photons, cluster, glossy, counts);
  }
}

void collect(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster,
             std::vector<ReversePair>& pairs, ReverseCounts& counts) {
  switch (photons.kernel) {
    case ReverseKernel::box:
      return search(part, photons, cluster, Collector<Box>{part, photons, counts, pairs}, counts);
    case ReverseKernel::cone:
      return search(part, photons, cluster, Collector<Cone>{part, photons, counts, pairs}, counts);
    case ReverseKernel::epanechnikov:
      return search(part, photons, cluster, Collector<Epanechnikov>{part, photons, counts, pairs}, counts);
    case ReverseKernel::gaussian:
      return search(part, photons, cluster, Collector<Gaussian>{part, photons, counts, pairs}, counts);
  }
}

void count(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster,
           ReverseCounts& counts) {
  search(part, photons, cluster, Counter{part, photons, counts}, counts);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(sum);
HWY_EXPORT(sum_glossy);
HWY_EXPORT(collect);
HWY_EXPORT(count);
}  // namespace

void reverse_sum(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster,
                 ReverseCounts& counts) {
  HWY_DYNAMIC_DISPATCH(sum)(part, photons, cluster, counts);
}

void reverse_sum_glossy(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster,
                        const ReverseGlossy& glossy, ReverseCounts& counts) {
  HWY_DYNAMIC_DISPATCH(sum_glossy)(part, photons, cluster, glossy, counts);
}

void reverse_collect(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster,
                     std::vector<ReversePair>& pairs, ReverseCounts& counts) {
  HWY_DYNAMIC_DISPATCH(collect)(part, photons, cluster, pairs, counts);
}

void reverse_count(const ReverseSubtreeView& part, const ReversePhotons& photons, const ReverseCluster& cluster,
                   ReverseCounts& counts) {
  HWY_DYNAMIC_DISPATCH(count)(part, photons, cluster, counts);
}

}  // namespace glowworm
#endif  // HWY_ONCE
