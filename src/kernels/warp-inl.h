// Vector versions of the sampling warps of core/warp.h and the vectors of core/vec.h; compiled once for every
// instruction set.
#if defined(GLOWWORM_KERNELS_WARP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLOWWORM_KERNELS_WARP_INL_H_
#undef GLOWWORM_KERNELS_WARP_INL_H_
#else
#define GLOWWORM_KERNELS_WARP_INL_H_
#endif

#include <hwy/highway.h>

#include "core/vec.h"
#include "kernels/sobol-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

// Products and sums are rounded separately, as in the scalar code, so that a scene has the same rays and photons on
// every instruction set.
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

/// The third coordinate of square_to_cosine_hemisphere() of core/warp.h.
HWY_INLINE SobolNumbers above_disk(SobolNumbers x, SobolNumbers y) {
  const SobolTag f;
  return hn::Sqrt(hn::Max(hn::Zero(f), hn::Sub(hn::Sub(hn::Set(f, 1.0f), hn::Mul(x, x)), hn::Mul(y, y))));
}

/// Vec3 of core/vec.h.
struct Triple {
  SobolNumbers x, y, z;
};

HWY_INLINE Triple load(const float* const* arrays, std::size_t i) {
  const SobolTag f;
  return {hn::LoadU(f, arrays[0] + i), hn::LoadU(f, arrays[1] + i), hn::LoadU(f, arrays[2] + i)};
}
HWY_INLINE void store(Triple a, float* const* arrays, std::size_t i) {
  const SobolTag f;
  hn::StoreU(a.x, f, arrays[0] + i);
  hn::StoreU(a.y, f, arrays[1] + i);
  hn::StoreU(a.z, f, arrays[2] + i);
}
HWY_INLINE Triple times(Triple a, SobolNumbers s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }
HWY_INLINE Triple minus(Triple a, Triple b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }
HWY_INLINE Triple over(Triple a, SobolNumbers s) { return {hn::Div(a.x, s), hn::Div(a.y, s), hn::Div(a.z, s)}; }
/// (a s + b t) + c, in this order.
HWY_INLINE Triple weighted(Triple a, SobolNumbers s, Triple b, SobolNumbers t, Triple c, SobolNumbers u) {
  const auto part = [&](SobolNumbers ax, SobolNumbers bx, SobolNumbers cx)
                        HWY_ATTR { return hn::Add(multiply_add(ax, s, hn::Mul(bx, t)), hn::Mul(cx, u)); };
  return {part(a.x, b.x, c.x), part(a.y, b.y, c.y), part(a.z, b.z, c.z)};
}
/// (a + b s) + c t
HWY_INLINE Triple moved(Triple a, Triple b, SobolNumbers s, Triple c, SobolNumbers t) {
  const auto part = [&](SobolNumbers ax, SobolNumbers bx, SobolNumbers cx)
                        HWY_ATTR { return multiply_add(cx, t, multiply_add(bx, s, ax)); };
  return {part(a.x, b.x, c.x), part(a.y, b.y, c.y), part(a.z, b.z, c.z)};
}
HWY_INLINE SobolNumbers dot(Triple a, Triple b) {
  return hn::Add(multiply_add(a.x, b.x, hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <typename Choice>
HWY_INLINE Triple choose(Choice first, Triple a, Triple b) {
  return {hn::IfThenElse(first, a.x, b.x), hn::IfThenElse(first, a.y, b.y), hn::IfThenElse(first, a.z, b.z)};
}
/// v if `side` is not negative, otherwise -v.
HWY_INLINE Triple on_side(Triple v, SobolNumbers side) {
  const auto behind = hn::Lt(side, hn::Zero(SobolTag()));
  return choose(behind, {hn::Neg(v.x), hn::Neg(v.y), hn::Neg(v.z)}, v);
}
HWY_INLINE SobolNumbers largest(Triple a) { return hn::Max(a.x, hn::Max(a.y, a.z)); }

/// Frame::from_normal(n).to_world({x, y, z}) of core/frame.h.
HWY_INLINE Triple from_frame_of(Triple n, SobolNumbers x, SobolNumbers y, SobolNumbers z) {
  const SobolTag f;
  const SobolNumbers one = hn::Set(f, 1.0f), sign = hn::CopySign(one, n.z);
  const SobolNumbers a = hn::Div(hn::Set(f, -1.0f), hn::Add(sign, n.z));
  const SobolNumbers b = hn::Mul(hn::Mul(n.x, n.y), a);
  const Triple s = {hn::Add(one, hn::Mul(hn::Mul(hn::Mul(sign, n.x), n.x), a)), hn::Mul(sign, b),
                    hn::Mul(hn::Neg(sign), n.x)};
  const Triple t = {b, hn::Add(sign, hn::Mul(hn::Mul(n.y, n.y), a)), hn::Neg(n.y)};
  return weighted(s, x, t, y, n, z);
}

/// offset_origin() of core/offset_origin.h.
HWY_INLINE Triple offset_origins(Triple p, Triple n, SobolNumbers offset) {
  return {multiply_add(n.x, offset, p.x), multiply_add(n.y, offset, p.y), multiply_add(n.z, offset, p.z)};
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
