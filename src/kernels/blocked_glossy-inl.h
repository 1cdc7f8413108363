// The blocked engine's groups of glossy points; compiled once for every instruction set.
#if defined(GLOWWORM_KERNELS_BLOCKED_GLOSSY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLOWWORM_KERNELS_BLOCKED_GLOSSY_INL_H_
#undef GLOWWORM_KERNELS_BLOCKED_GLOSSY_INL_H_
#else
#define GLOWWORM_KERNELS_BLOCKED_GLOSSY_INL_H_
#endif

#include "kernels/blocked-inl.h"
#include "kernels/glossy-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

/// A group of points of a glossy model: tests a photon against a vector of points, and evaluates f if it reaches one.
template <GlossyModel model>
class GlossyGroup {
 public:
  HWY_INLINE void start(const QueryRun& run, const GlossyPoints* glossy, std::size_t first) {
    first_ = first;
    glossy_ = glossy;
    valid_ = run.count > first ? HWY_MIN(run.count - first, kGroupWidth) : 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < kGroupWidth; ++i) {
        sums_[axis][i] = 0;
        position_[axis][i] = i < valid_ ? run.position[axis][first + i] : 1e19f;
        normal_[axis][i] = run.normal[axis][first + i];
      }
  }

  HWY_INLINE std::size_t valid() const { return valid_; }

  template <bool compare>
  HWY_INLINE std::uint64_t add(const BlockTree& tree, const std::uint32_t* list, std::size_t length) {
    constexpr auto kBlockFloats = static_cast<std::uint32_t>(sizeof(PhotonBlock) / sizeof(float));
    const TileTag d;
    const auto* photons = reinterpret_cast<const float*>(tree.blocks);
    std::uint64_t inside_count = 0;
    for (std::size_t i = 0; i < length; ++i) {
      const float* p = photons + list[i];
      const float* direction = tree.directions + 3 * (list[i] / kBlockFloats * kBlockWidth + list[i] % kBlockFloats);
      for (std::size_t first = 0; first < kGroupWidth; first += kTileLanes) {
        TileVector t = hn::Zero(d);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const TileVector away = hn::Sub(hn::Set(d, p[axis * kBlockWidth]), hn::Load(d, position_[axis] + first));
          t = hn::MulAdd(away, away, t);
        }
        t = hn::Mul(t, hn::Set(d, p[3 * kBlockWidth]));
        hn::Mask<TileTag> inside = hn::Lt(t, hn::Set(d, 1.0f));
        if constexpr (compare) {
          const auto product = [&](std::size_t axis) HWY_ATTR {
            return hn::Mul(hn::Load(d, normal_[axis] + first), hn::Set(d, p[(4 + axis) * kBlockWidth]));
          };
          inside = hn::And(
              inside, hn::Gt(hn::Add(hn::Add(product(0), product(1)), product(2)), hn::Set(d, tree.min_normal_cosine)));
          inside = cut_at(tree, list[i], p, position_[0] + first, position_[1] + first, position_[2] + first, inside);
        }
        if (hn::AllFalse(d, inside)) continue;
        inside_count += hn::CountTrue(d, inside);
        TileVector weight = hn::Zero(d);
        with_kernel_shape(tree.kernel, [&](auto shape) HWY_ATTR {
          weight = hn::IfThenElseZero(inside, kernel_profile_at<decltype(shape)::value>(d, t));
        });
        const GlossyValue<TileTag> f = glossy_value<model>(d, *glossy_, first_ + first, direction);
        add_color(0, first, hn::Mul(weight, hn::Set(d, p[7 * kBlockWidth])), f.r);
        add_color(1, first, hn::Mul(weight, hn::Set(d, p[8 * kBlockWidth])), f.g);
        add_color(2, first, hn::Mul(weight, hn::Set(d, p[9 * kBlockWidth])), f.b);
      }
    }
    return inside_count;
  }

  HWY_INLINE void finish(const QueryRun& run) const {
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < kGroupWidth; ++i) run.sum[c][first_ + i] = sums_[c][i];
  }

 private:
  HWY_INLINE void add_color(std::size_t channel, std::size_t first, TileVector flux, TileVector f) {
    const TileTag d;
    // Lanes beyond the photon's reach may hold any finite number: their flux is 0.
    float* sum = sums_[channel] + first;
    hn::Store(hn::MulAdd(flux, f, hn::Load(d, sum)), d, sum);
  }

  std::size_t first_, valid_;
  const GlossyPoints* glossy_;
  alignas(64) float position_[3][kGroupWidth];
  alignas(64) float normal_[3][kGroupWidth];
  alignas(64) float sums_[3][kGroupWidth];
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
