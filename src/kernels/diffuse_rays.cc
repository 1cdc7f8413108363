#include "kernels/diffuse_rays.h"

#include "core/random.h"
#include "core/vec.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/diffuse_rays.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "kernels/sobol-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

// Products and sums are rounded apart, as the plain loops round them: the same scene has the same rays on every
// instruction set.
HWY_INLINE SobolNumbers multiply_add(SobolNumbers a, SobolNumbers b, SobolNumbers c) {
  return hn::Add(hn::Mul(a, b), c);
}

/// sine_and_cosine_of_octant() of core/warp.h.
HWY_INLINE void sine_and_cosine(SobolNumbers x, SobolNumbers& sine, SobolNumbers& cosine) {
  const SobolTag f;
  const SobolNumbers square = hn::Mul(x, x);
  const SobolNumbers s = multiply_add(multiply_add(hn::Set(f, -1.9515295891e-4f), square, hn::Set(f, 8.3321608736e-3f)),
                                      square, hn::Set(f, -1.6666654611e-1f));
  sine = multiply_add(hn::Mul(s, square), x, x);
  const SobolNumbers c =
      multiply_add(multiply_add(hn::Set(f, 2.443315711809948e-5f), square, hn::Set(f, -1.388731625493765e-3f)), square,
                   hn::Set(f, 4.166664568298827e-2f));
  cosine = multiply_add(hn::Mul(c, square), square, hn::Sub(hn::Set(f, 1.0f), hn::Mul(hn::Set(f, 0.5f), square)));
}

/// square_to_disk() of core/warp.h.
HWY_INLINE void disk(SobolNumbers u, SobolNumbers v, SobolNumbers& x, SobolNumbers& y) {
  const SobolTag f;
  const SobolNumbers one = hn::Set(f, 1.0f), zero = hn::Zero(f);
  const SobolNumbers a = hn::Sub(hn::Add(u, u), one), b = hn::Sub(hn::Add(v, v), one);
  const auto steep = hn::Ge(hn::Abs(b), hn::Abs(a));
  const SobolNumbers radius = hn::IfThenElse(steep, b, a), other = hn::IfThenElse(steep, a, b);
  const auto centre = hn::Eq(radius, zero);
  const SobolNumbers ratio = hn::Div(other, hn::IfThenElse(centre, one, radius));
  SobolNumbers sine, cosine;
  sine_and_cosine(hn::Mul(ratio, hn::Set(f, kPi / 4)), sine, cosine);
  x = hn::Mul(radius, hn::IfThenElse(steep, sine, cosine));
  y = hn::Mul(radius, hn::IfThenElse(steep, cosine, sine));
}

void rays(const DiffuseRayPoints& points, const DiffuseRayCell& cell, const DiffuseRays& out) {
  const SobolTag f;
  const SobolBitsTag u;
  constexpr std::size_t kLanes = hn::MaxLanes(SobolTag());
  static_assert(kLanes <= kDiffuseRayPadding);
  const SobolBits seed = hn::Set(u, Sampler::seed_key(cell.seed)), salt = hn::Set(u, cell.sequence_salt);
  const SobolBits stride = hn::Set(u, cell.sample_stride), offset = hn::Set(u, cell.sample_offset);
  const SobolNumbers zero = hn::Zero(f), one = hn::Set(f, 1.0f);
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    const SobolBits sequence = combine_bits(hn::LoadU(u, points.sequence + i), salt);
    const SobolBits key = combine_bits(combine_bits(seed, sequence), hn::Zero(u));
    SobolNumbers a, b, x, y;
    sobol_pair(key, hn::Add(hn::Mul(hn::LoadU(u, points.sample + i), stride), offset), a, b);
    disk(multiply_add(a, hn::Set(f, cell.side[0]), hn::Set(f, cell.low[0])),
         multiply_add(b, hn::Set(f, cell.side[1]), hn::Set(f, cell.low[1])), x, y);
    const SobolNumbers z = hn::Sqrt(hn::Max(zero, hn::Sub(hn::Sub(one, hn::Mul(x, x)), hn::Mul(y, y))));
    SobolNumbers side = zero;
    for (int axis = 0; axis < 3; ++axis) {
      SobolNumbers d = hn::Mul(hn::LoadU(f, points.frame[axis] + i), x);
      d = multiply_add(hn::LoadU(f, points.frame[3 + axis] + i), y, d);
      d = multiply_add(hn::LoadU(f, points.frame[6 + axis] + i), z, d);
      hn::StoreU(d, f, out.direction[axis] + i);
      side = multiply_add(d, hn::LoadU(f, points.normal[axis] + i), side);
    }
    hn::StoreU(hn::IfThenElseZero(hn::Gt(side, zero), z), f, out.cosine + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(rays);
}

void diffuse_rays(const DiffuseRayPoints& points, const DiffuseRayCell& cell, const DiffuseRays& out) {
  HWY_DYNAMIC_DISPATCH(rays)(points, cell, out);
}

}  // namespace glowworm
#endif  // HWY_ONCE
