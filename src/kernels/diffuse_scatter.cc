#include "kernels/diffuse_scatter.h"

#include "core/shading_light.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/diffuse_scatter.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "kernels/warp-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

/// The points where paths arrived.
struct Places {
  Triple position, geometric, shading;
};

HWY_INLINE Places places_of(const ArrivedPaths& in, std::size_t i) {
  const SobolTag f;
  const SobolNumbers one = hn::Set(f, 1.0f);
  const SobolNumbers u = hn::LoadU(f, in.barycentric[0] + i), v = hn::LoadU(f, in.barycentric[1] + i);
  const SobolNumbers w = hn::Sub(hn::Sub(one, u), v);
  Places places;
  places.position = moved(load(in.corner, i), load(in.edges, i), u, load(in.edges + 3, i), v);
  places.geometric = load(in.geometric, i);
  const Triple n =
      weighted(load(in.vertex_normals, i), w, load(in.vertex_normals + 3, i), u, load(in.vertex_normals + 6, i), v);
  const SobolNumbers squared = dot(n, n);
  const Triple unit = over(n, hn::Sqrt(squared));
  places.shading =
      choose(hn::Gt(squared, hn::Set(f, 1e-12f)), on_side(unit, dot(unit, places.geometric)), places.geometric);
  return places;
}

/// arrival_factor() of core/shading_light.h.
HWY_INLINE SobolNumbers factor_of(const Places& places, SobolNumbers geometric_in, Triple back) {
  const SobolTag f;
  const SobolNumbers zero = hn::Zero(f), geometric = hn::Abs(geometric_in), along = dot(places.shading, back);
  const SobolNumbers shading = hn::IfThenElse(hn::Lt(geometric_in, zero), hn::Neg(along), along);
  const SobolNumbers mirrored =
      hn::Sub(shading, hn::Mul(hn::Add(geometric, geometric), dot(places.shading, places.geometric)));
  const SobolNumbers both = hn::Add(hn::Max(shading, zero), hn::Max(mirrored, zero));
  return hn::Min(hn::Div(both, hn::Max(geometric, hn::Set(f, kMinShadingCosine))), hn::Set(f, kMaxShadingFactor));
}

void scatter(const ArrivedPaths& in, const ScatteredPaths& out) {
  const SobolTag f;
  const SobolBitsTag u;
  constexpr std::size_t kLanes = hn::MaxLanes(SobolTag());
  static_assert(kLanes <= kDiffuseScatterPadding);
  const SobolNumbers zero = hn::Zero(f), one = hn::Set(f, 1.0f);
  for (std::size_t i = 0; i < in.count; i += kLanes) {
    const Places places = places_of(in, i);
    const Triple back = load(in.back, i), flux = load(in.flux, i), reflectance = load(in.reflectance, i);
    const SobolNumbers geometric_in = dot(places.geometric, back);
    const SobolNumbers factor = factor_of(places, geometric_in, back);
    const Triple n = on_side(places.geometric, geometric_in);
    store(places.position, out.position, i);
    store(n, out.normal, i);
    store(times(flux, factor), out.photon_flux, i);
    store(offset_origins(places.position, n, hn::LoadU(f, in.offset + i)), out.origin, i);

    SobolNumbers x, y;
    disk(hn::LoadU(f, in.square[0] + i), hn::LoadU(f, in.square[1] + i), x, y);
    const SobolNumbers z = above_disk(x, y);
    store(from_frame_of(n, x, y, z), out.direction, i);
    const Triple next =
        times({hn::Mul(flux.x, reflectance.x), hn::Mul(flux.y, reflectance.y), hn::Mul(flux.z, reflectance.z)}, factor);
    const SobolNumbers survival = hn::Min(one, hn::Div(largest(next), hn::Max(largest(flux), hn::Set(f, 1e-30f))));

    const auto black =
        hn::And(hn::And(hn::Eq(reflectance.x, zero), hn::Eq(reflectance.y, zero)), hn::Eq(reflectance.z, zero));
    const auto left = hn::AndNot(black, hn::Gt(factor, zero));
    const auto survives = hn::And(hn::Gt(survival, zero), hn::Lt(hn::LoadU(f, in.roulette + i), survival));
    const auto goes_on = hn::And(left, hn::And(hn::Gt(z, zero), survives));
    const Triple scattered = over(next, survival);
    store({hn::IfThenElseZero(goes_on, scattered.x), hn::IfThenElseZero(goes_on, scattered.y),
           hn::IfThenElseZero(goes_on, scattered.z)},
          out.flux, i);
    const auto bits = [&](auto mask, std::uint32_t bit) HWY_ATTR {
      return hn::BitCast(u, hn::IfThenElseZero(mask, hn::BitCast(f, hn::Set(u, bit))));
    };
    hn::StoreU(hn::Or(bits(left, kPhotonLeft), bits(goes_on, kPathGoesOn)), u, out.outcome + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(scatter);
}

void diffuse_scatter(const ArrivedPaths& arrived, const ScatteredPaths& scattered) {
  HWY_DYNAMIC_DISPATCH(scatter)(arrived, scattered);
}

}  // namespace glowworm
#endif  // HWY_ONCE
