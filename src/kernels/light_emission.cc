#include "kernels/light_emission.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_emission.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "kernels/warp-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t kLanes = hn::MaxLanes(SobolTag());
static_assert(kLanes <= kLightEmissionPadding);

/// flux / probability * guide weight, in this order.
HWY_INLINE void store_flux(Triple flux, const EmissionChoices& in, const EmittedRays& out, std::size_t i) {
  const SobolTag f;
  const SobolNumbers chosen = hn::Div(hn::Set(f, 1.0f), hn::LoadU(f, in.probability + i));
  store(times(times(flux, chosen), hn::LoadU(f, in.guide_weight + i)), out.flux, i);
}

void from_triangles(const EmissionChoices& in, const EmittingTriangles& triangles, const EmittedRays& out) {
  const SobolTag f;
  const SobolBitsTag u;
  const SobolNumbers one = hn::Set(f, 1.0f), two = hn::Set(f, 2.0f);
  for (std::size_t i = 0; i < in.count; i += kLanes) {
    const Triple a = load(triangles.corner, i), e1 = load(triangles.edges, i), e2 = load(triangles.edges + 3, i);
    const SobolNumbers r = hn::Sqrt(hn::LoadU(f, in.place[0] + i)), t = hn::LoadU(f, in.place[1] + i);
    const Triple position = moved(a, e1, hn::Mul(r, hn::Sub(one, t)), e2, hn::Mul(r, t));
    const Triple front = load(triangles.normal, i);
    const SobolNumbers doubled_area = dot(cross(e1, e2), front);

    const SobolNumbers x = hn::LoadU(f, in.square[0] + i);
    const auto both = hn::MaskFromVec(
        hn::BitCast(f, hn::Neg(hn::BitCast(hn::RebindToSigned<SobolTag>(), hn::LoadU(u, triangles.two_sided + i)))));
    const auto upper = hn::Ge(x, hn::Set(f, 0.5f));
    const auto back = hn::And(both, upper);
    const SobolNumbers halved = hn::Sub(hn::Mul(two, x), hn::IfThenElseZero(upper, one));
    const Triple n = choose(back, {hn::Neg(front.x), hn::Neg(front.y), hn::Neg(front.z)}, front);
    SobolNumbers disk_x, disk_y;
    disk(hn::IfThenElse(both, halved, x), hn::LoadU(f, in.square[1] + i), disk_x, disk_y);
    store(from_frame_of(n, disk_x, disk_y, above_disk(disk_x, disk_y)), out.direction, i);
    store(offset_origins(position, n, hn::LoadU(f, triangles.offset + i)), out.origin, i);
    const SobolNumbers share = hn::Mul(hn::Mul(hn::Set(f, kPi * 0.5f), doubled_area), hn::IfThenElse(both, two, one));
    store_flux(times(load(triangles.radiance, i), share), in, out, i);
  }
}

void from_afar(const EmissionChoices& in, const DistantLight& light, const EmittedRays& out) {
  const SobolTag f;
  const SobolNumbers radius = hn::Set(f, light.radius), area = hn::Set(f, kPi * light.radius * light.radius);
  const Triple center = {hn::Set(f, light.center[0]), hn::Set(f, light.center[1]), hn::Set(f, light.center[2])};
  for (std::size_t i = 0; i < in.count; i += kLanes) {
    const Triple direction = load(light.direction, i);
    SobolNumbers x, y;
    disk(hn::LoadU(f, in.place[0] + i), hn::LoadU(f, in.place[1] + i), x, y);
    const Triple offset = from_frame_of(direction, hn::Mul(x, radius), hn::Mul(y, radius), hn::Neg(radius));
    store({hn::Add(center.x, offset.x), hn::Add(center.y, offset.y), hn::Add(center.z, offset.z)}, out.origin, i);
    store(direction, out.direction, i);
    store_flux(times(load(light.irradiance, i), area), in, out, i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(from_triangles);
HWY_EXPORT(from_afar);
}  // namespace

void emit_from_triangles(const EmissionChoices& choices, const EmittingTriangles& triangles, const EmittedRays& out) {
  HWY_DYNAMIC_DISPATCH(from_triangles)(choices, triangles, out);
}

void emit_from_afar(const EmissionChoices& choices, const DistantLight& light, const EmittedRays& out) {
  HWY_DYNAMIC_DISPATCH(from_afar)(choices, light, out);
}

}  // namespace glowworm
#endif  // HWY_ONCE
