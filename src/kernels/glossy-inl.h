// Evaluates f of glossy query points, one per lane, towards a photon; compiled once for every instruction set.
#if defined(GLOWWORM_KERNELS_GLOSSY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef GLOWWORM_KERNELS_GLOSSY_INL_H_
#undef GLOWWORM_KERNELS_GLOSSY_INL_H_
#else
#define GLOWWORM_KERNELS_GLOSSY_INL_H_
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "kernels/glossy.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Reflectance of a dielectric (fresnel_dielectric() of bsdf/fresnel.h). At total reflection the transmitted cosine is
/// 0, and both terms are 1.
template <class D>
HWY_INLINE hn::Vec<D> glossy_dielectric(D d, hn::Vec<D> cosine, hn::Vec<D> eta) {
  const auto one = hn::Set(d, 1.0f);
  cosine = hn::Min(cosine, one);
  const auto sine = hn::Div(hn::NegMulAdd(cosine, cosine, one), hn::Mul(eta, eta));
  const auto beyond = hn::Sqrt(hn::Max(hn::Zero(d), hn::Sub(one, sine)));
  const auto a = hn::Mul(eta, cosine), b = hn::Mul(eta, beyond);
  const auto parallel = hn::Div(hn::Sub(a, beyond), hn::Add(a, beyond));
  const auto perpendicular = hn::Div(hn::Sub(cosine, b), hn::Add(cosine, b));
  return hn::Mul(hn::Set(d, 0.5f), hn::MulAdd(parallel, parallel, hn::Mul(perpendicular, perpendicular)));
}

/// Reflectance of a conductor (fresnel_conductor() of bsdf/fresnel.h).
template <class D>
HWY_INLINE hn::Vec<D> glossy_conductor(D d, hn::Vec<D> cosine, hn::Vec<D> eta, hn::Vec<D> k) {
  const auto one = hn::Set(d, 1.0f), zero = hn::Zero(d), half = hn::Set(d, 0.5f), tiny = hn::Set(d, 1e-30f);
  cosine = hn::Min(cosine, one);
  const auto cosine2 = hn::Mul(cosine, cosine), sine2 = hn::Sub(one, cosine2);
  const auto t0 = hn::Sub(hn::Sub(hn::Mul(eta, eta), hn::Mul(k, k)), sine2);
  const auto twice = hn::Mul(hn::Add(eta, eta), k);
  const auto ab = hn::Sqrt(hn::MulAdd(t0, t0, hn::Mul(twice, twice)));
  const auto t1 = hn::Add(ab, cosine2);
  const auto a = hn::Sqrt(hn::Max(zero, hn::Mul(half, hn::Add(ab, t0))));
  const auto t2 = hn::Mul(hn::Add(cosine, cosine), a);
  const auto perpendicular = hn::Div(hn::Sub(t1, t2), hn::Max(tiny, hn::Add(t1, t2)));
  const auto t3 = hn::MulAdd(cosine2, ab, hn::Mul(sine2, sine2)), t4 = hn::Mul(t2, sine2);
  const auto ratio = hn::Div(hn::Sub(t3, t4), hn::Max(tiny, hn::Add(t3, t4)));
  return hn::Min(one, hn::Max(zero, hn::Mul(half, hn::MulAdd(perpendicular, ratio, perpendicular))));
}

/// Positions in the curves of a vector of points, for a cosine.
template <class D>
struct GlossyPlace {
  hn::Vec<hn::RebindToSigned<D>> index;
  hn::Vec<D> fraction;

  HWY_INLINE GlossyPlace(D d, hn::Vec<D> cosine, const float* tables_of_points) {
    const hn::RebindToSigned<D> di;
    constexpr float kSteps = kGlossyCurve - 1;
    cosine = hn::Min(cosine, hn::Set(d, 1.0f));
    const auto node =
        hn::Min(hn::ConvertTo(di, hn::Mul(hn::Sqrt(cosine), hn::Set(d, kSteps))), hn::Set(di, kGlossyCurve - 2));
    const auto low = hn::ConvertTo(d, node);
    fraction = hn::Div(hn::NegMulAdd(low, low, hn::Mul(cosine, hn::Set(d, kSteps * kSteps))),
                       hn::MulAdd(hn::Set(d, 2.0f), low, hn::Set(d, 1.0f)));
    const auto first = hn::BitCast(di, hn::LoadU(d, tables_of_points));
    index = hn::Add(hn::Max(first, hn::Zero(di)), node);
  }
  HWY_INLINE hn::Vec<D> read(D d, const float* tables) const {
    const auto low = hn::GatherIndex(d, tables, index), high = hn::GatherIndex(d, tables + 1, index);
    return hn::MulAdd(hn::Sub(high, low), fraction, low);
  }
};

/// f times pi, by channel; black for lanes with wi behind the surface.
template <class D>
struct GlossyValue {
  hn::Vec<D> r, g, b;
};

/// The lobe of some points for one direction of light.
template <class D>
struct GlossyLobe {
  using V = hn::Vec<D>;

  /// @param first_point of the lanes @param wi x, y, z, world space
  HWY_INLINE GlossyLobe(D d, const GlossyPoints& of_points, std::size_t first_point, const float* wi)
      : points(of_points), point(first_point) {
    const V one = hn::Set(d, 1.0f), zero = hn::Zero(d), half = hn::Set(d, 0.5f);
    const V x = hn::Set(d, wi[0]), y = hn::Set(d, wi[1]), z = hn::Set(d, wi[2]);
    const V nx = field(d, kGlossyNormal), ny = field(d, kGlossyNormal + 1), nz = field(d, kGlossyNormal + 2);
    cosine = hn::MulAdd(nx, x, hn::MulAdd(ny, y, hn::Mul(nz, z)));
    c = hn::Max(cosine, hn::Set(d, 1e-12f));
    // Without normalising the half vector: v = wo + wi, with tangential part t and normal part n.
    const V vx = hn::Add(field(d, kGlossyWo), x), vy = hn::Add(field(d, kGlossyWo + 1), y),
            vz = hn::Add(field(d, kGlossyWo + 2), z);
    const V along = hn::MulAdd(nx, vx, hn::MulAdd(ny, vy, hn::Mul(nz, vz)));
    const V tx = hn::NegMulAdd(along, nx, vx), ty = hn::NegMulAdd(along, ny, vy), tz = hn::NegMulAdd(along, nz, vz);
    const V t2 = hn::MulAdd(tx, tx, hn::MulAdd(ty, ty, hn::Mul(tz, tz))), n2 = hn::Mul(along, along);
    const V length2 = hn::Add(t2, n2), alpha2 = field(d, kGlossyAlphaSquared);
    const V spread = hn::MulAdd(alpha2, n2, t2);
    c2 = hn::Mul(c, c);
    const V shadowing = hn::MulAdd(c, field(d, kGlossyMasking),
                                   hn::Mul(half, hn::Sqrt(hn::MulAdd(alpha2, hn::Max(zero, hn::Sub(one, c2)), c2))));
    lobe = hn::Div(hn::Mul(field(d, kGlossyLobe), hn::Mul(length2, length2)),
                   hn::Max(hn::Mul(hn::Mul(spread, spread), shadowing), hn::Set(d, 1e-30f)));
    // For unit vectors.
    cosine_of_half = hn::Mul(half, hn::Sqrt(length2));
  }

  HWY_INLINE V field(D d, std::size_t f) const { return hn::LoadU(d, points.fields + f * points.stride + point); }
  HWY_INLINE GlossyPlace<D> place_in_curves(D d) const {
    return GlossyPlace<D>(d, c, points.fields + kGlossyTable * points.stride + point);
  }
  /// Adds what repeated reflection brings of the light that the lobe loses.
  HWY_INLINE void add_multiple(D d, V lost, GlossyValue<D>& f) const {
    lost = hn::Max(hn::Zero(d), lost);
    f = {hn::MulAdd(lost, field(d, kGlossyMultiple), f.r), hn::MulAdd(lost, field(d, kGlossyMultiple + 1), f.g),
         hn::MulAdd(lost, field(d, kGlossyMultiple + 2), f.b)};
  }

  const GlossyPoints& points;
  const std::size_t point;
  V cosine;          ///< of the light at the surface
  V c, c2;           ///< that above 0, and its square
  V lobe;            ///< of microfacets, without Fresnel's factor
  V cosine_of_half;  ///< between wi and the half vector
};

template <class D>
HWY_INLINE GlossyValue<D> conductor_value(D d, const GlossyLobe<D>& at) {
  const auto channel = [&](std::size_t i) HWY_ATTR {
    return hn::Mul(
        at.lobe, glossy_conductor(d, at.cosine_of_half, at.field(d, kGlossyFirst + i), at.field(d, kGlossySecond + i)));
  };
  GlossyValue<D> f{channel(0), channel(1), channel(2)};
  const GlossyPlace<D> place = at.place_in_curves(d);
  at.add_multiple(d,
                  hn::Sub(hn::Sub(hn::Set(d, 1.0f), place.read(d, at.points.tables)),
                          place.read(d, at.points.tables + kGlossyCurve)),
                  f);
  return f;
}

template <class D>
HWY_INLINE GlossyValue<D> schlick_value(D d, const GlossyLobe<D>& at) {
  using V = hn::Vec<D>;
  const V one = hn::Set(d, 1.0f);
  const V m = hn::Sub(one, hn::Min(at.cosine_of_half, one)), m2 = hn::Mul(m, m), term = hn::Mul(hn::Mul(m2, m2), m);
  const V kept = hn::Mul(at.lobe, hn::Sub(one, term)),
          grazing = hn::Mul(at.lobe, hn::Mul(term, at.field(d, kGlossyFirstGrazing)));
  GlossyValue<D> f{hn::MulAdd(kept, at.field(d, kGlossyFirst), grazing),
                   hn::MulAdd(kept, at.field(d, kGlossyFirst + 1), grazing),
                   hn::MulAdd(kept, at.field(d, kGlossyFirst + 2), grazing)};
  const GlossyPlace<D> place = at.place_in_curves(d);
  const V scale = place.read(d, at.points.tables), bias = place.read(d, at.points.tables + kGlossyCurve),
          left = hn::NegMulAdd(bias, at.field(d, kGlossySecondGrazing), one);
  const auto add = [&](V value, std::size_t i) HWY_ATTR {
    return hn::MulAdd(at.field(d, kGlossyDiffuse + i), hn::NegMulAdd(scale, at.field(d, kGlossySecond + i), left),
                      value);
  };
  f = {add(f.r, 0), add(f.g, 1), add(f.b, 2)};
  at.add_multiple(d, hn::Sub(hn::Sub(one, scale), bias), f);
  return f;
}

template <class D>
HWY_INLINE GlossyValue<D> coated_value(D d, const GlossyLobe<D>& at) {
  using V = hn::Vec<D>;
  const V one = hn::Set(d, 1.0f), eta = at.field(d, kGlossyIndex), thickness = at.field(d, kGlossyThickness);
  const V mirrored = hn::Mul(at.lobe, glossy_dielectric(d, at.cosine_of_half, eta));
  const hn::RebindToSigned<D> di;
  const auto smooth = hn::RebindMask(d, hn::Lt(hn::BitCast(di, at.field(d, kGlossyTable)), hn::Zero(di)));
  V passed = hn::Zero(d), lost = hn::Zero(d);
  if (!hn::AllTrue(d, smooth)) {
    const GlossyPlace<D> place = at.place_in_curves(d);
    lost = hn::IfThenZeroElse(smooth, place.read(d, at.points.tables + kGlossyCurve));
    passed = hn::MulAdd(at.field(d, kGlossyThrough), lost, place.read(d, at.points.tables));
  }
  if (!hn::AllFalse(d, smooth)) passed = hn::IfThenElse(smooth, hn::Sub(one, glossy_dielectric(d, at.c, eta)), passed);
  const V inner = hn::Sqrt(hn::Max(hn::Set(d, 1e-12f), hn::Sub(one, hn::Div(hn::Sub(one, at.c2), hn::Mul(eta, eta)))));
  passed = hn::Mul(passed, hn::Exp(d, hn::Neg(hn::Div(thickness, inner))));
  GlossyValue<D> f{hn::MulAdd(passed, at.field(d, kGlossyDiffuse), mirrored),
                   hn::MulAdd(passed, at.field(d, kGlossyDiffuse + 1), mirrored),
                   hn::MulAdd(passed, at.field(d, kGlossyDiffuse + 2), mirrored)};
  at.add_multiple(d, lost, f);
  return f;
}

/// @param point  the first of the lanes' points
/// @param wi     x, y, z, world space
template <GlossyModel model, class D>
HWY_INLINE GlossyValue<D> glossy_value(D d, const GlossyPoints& points, std::size_t point, const float* wi) {
  const GlossyLobe<D> at(d, points, point, wi);
  GlossyValue<D> f;
  if constexpr (model == GlossyModel::conductor) f = conductor_value(d, at);
  if constexpr (model == GlossyModel::schlick) f = schlick_value(d, at);
  if constexpr (model == GlossyModel::coated) f = coated_value(d, at);
  const auto above = hn::Gt(at.cosine, hn::Zero(d));
  return {hn::IfThenElseZero(above, f.r), hn::IfThenElseZero(above, f.g), hn::IfThenElseZero(above, f.b)};
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#endif
