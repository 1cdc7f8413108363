#include "kernels/diffuse_rays.h"

#include "core/random.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/diffuse_rays.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "core/vec.h"
#include "kernels/sobol-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t kLanes = hn::MaxLanes(SobolTag());
static_assert(kLanes <= kDiffuseRayPadding);

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
template <typename Choice>
HWY_INLINE Triple choose(Choice first, Triple a, Triple b) {
  return {hn::IfThenElse(first, a.x, b.x), hn::IfThenElse(first, a.y, b.y), hn::IfThenElse(first, a.z, b.z)};
}

void squares(const DiffuseRayPoints& points, const DiffuseRayCell& cell, const DiffuseSquare& out) {
  const SobolTag f;
  const SobolBitsTag u;
  const SobolBits seed = hn::Set(u, Sampler::seed_key(cell.seed)), salt = hn::Set(u, cell.sequence_salt);
  const SobolBits stride = hn::Set(u, cell.sample_stride), offset = hn::Set(u, cell.sample_offset);
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    const SobolBits sequence = combine_bits(hn::LoadU(u, points.sequence + i), salt);
    const SobolBits key = combine_bits(combine_bits(seed, sequence), hn::Zero(u));
    SobolNumbers a, b;
    sobol_pair(key, hn::Add(hn::Mul(hn::LoadU(u, points.sample + i), stride), offset), a, b);
    hn::StoreU(multiply_add(a, hn::Set(f, cell.side[0]), hn::Set(f, cell.low[0])), f, out.x + i);
    hn::StoreU(multiply_add(b, hn::Set(f, cell.side[1]), hn::Set(f, cell.low[1])), f, out.y + i);
  }
}

void rays(const DiffuseRayPoints& points, const DiffuseSquare& square, const DiffuseRays& out) {
  const SobolTag f;
  const SobolNumbers zero = hn::Zero(f);
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    SobolNumbers x, y;
    disk(hn::LoadU(f, square.x + i), hn::LoadU(f, square.y + i), x, y);
    const SobolNumbers z = above_disk(x, y);
    SobolNumbers side = zero, normals = zero;
    const auto add_axis = [&](std::size_t axis) HWY_ATTR {
      const SobolNumbers shading = hn::LoadU(f, points.frame[6 + axis] + i);
      const SobolNumbers normal = hn::LoadU(f, points.normal[axis] + i);
      SobolNumbers d = hn::Mul(hn::LoadU(f, points.frame[axis] + i), x);
      d = multiply_add(hn::LoadU(f, points.frame[3 + axis] + i), y, d);
      d = multiply_add(shading, z, d);
      side = multiply_add(d, normal, side);
      normals = multiply_add(shading, normal, normals);
      return d;
    };
    const Triple direction{add_axis(0), add_axis(1), add_axis(2)}, normal = load(points.normal, i);
    const SobolNumbers twice = hn::Add(side, side);
    store(choose(hn::Lt(side, zero), minus(direction, times(normal, twice)), direction), out.direction, i);
    const SobolNumbers image = hn::Max(hn::Sub(z, hn::Mul(twice, normals)), zero);
    hn::StoreU(hn::IfThenElseZero(hn::Ne(side, zero), hn::Add(z, image)), f, out.cosine + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(squares);
HWY_EXPORT(rays);
}  // namespace

void diffuse_squares(const DiffuseRayPoints& points, const DiffuseRayCell& cell, const DiffuseSquare& out) {
  HWY_DYNAMIC_DISPATCH(squares)(points, cell, out);
}

void diffuse_rays(const DiffuseRayPoints& points, const DiffuseSquare& square, const DiffuseRays& out) {
  HWY_DYNAMIC_DISPATCH(rays)(points, square, out);
}

}  // namespace glowworm
#endif  // HWY_ONCE
