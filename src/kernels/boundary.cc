#include "kernels/boundary.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/boundary.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include "kernels/kernel_shape-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

using F = hn::CappedTag<float, kBoundaryPadding>;
using U = hn::RebindToUnsigned<F>;
using FloatVector = hn::Vec<F>;

struct Vector3 {
  FloatVector x, y, z;
};

HWY_INLINE Vector3 set(const float* v) {
  const F f;
  return {hn::Set(f, v[0]), hn::Set(f, v[1]), hn::Set(f, v[2])};
}

HWY_INLINE Vector3 load(const float* const (&axes)[3], std::size_t first) {
  const F f;
  return {hn::LoadU(f, axes[0] + first), hn::LoadU(f, axes[1] + first), hn::LoadU(f, axes[2] + first)};
}

HWY_INLINE Vector3 minus(Vector3 a, Vector3 b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }

// Products are rounded before they are added, so that all instruction sets find the same hits.
HWY_INLINE Vector3 cross(Vector3 a, Vector3 b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

HWY_INLINE FloatVector dot(Vector3 a, Vector3 b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

std::size_t hits(const SegmentArrays& segments, const CornerAndEdges& triangle, float first, std::uint32_t* segment,
                 float* distance) {
  const F f;
  const U u;
  const Vector3 corner = set(triangle.corner), e0 = set(triangle.edge[0]), e1 = set(triangle.edge[1]);
  const FloatVector zero = hn::Zero(f), one = hn::Set(f, 1.0f), least = hn::Set(f, first);
  std::size_t found = 0;
  for (std::size_t begin = 0; begin < segments.count; begin += hn::Lanes(f)) {
    const Vector3 d = load(segments.direction, begin), s = minus(load(segments.origin, begin), corner);
    const Vector3 p = cross(d, e1), q = cross(s, e0);
    const FloatVector inverse = hn::Div(one, dot(e0, p));
    const FloatVector a = hn::Mul(dot(s, p), inverse), b = hn::Mul(dot(d, q), inverse);
    const FloatVector t = hn::Mul(dot(e1, q), inverse);
    const auto inside = hn::And(hn::And(hn::Ge(a, zero), hn::Ge(b, zero)), hn::Le(hn::Add(a, b), one));
    const auto within = hn::And(hn::And(hn::Ge(t, least), hn::Le(t, one)), hn::FirstN(f, segments.count - begin));
    const auto hit = hn::And(inside, within);
    if (hn::AllFalse(f, hit)) continue;
    hn::CompressStore(hn::Iota(u, static_cast<std::uint32_t>(begin)), hn::RebindMask(u, hit), u, segment + found);
    found += hn::CompressStore(t, hit, f, distance + found);
  }
  return found;
}

/// kernel_profile() where the square of the distance is below 1, else 0.
template <KernelShape shape>
HWY_INLINE FloatVector profile_within(FloatVector squared) {
  const F f;
  return hn::IfThenElseZero(hn::Lt(squared, hn::Set(f, 1.0f)), kernel_profile_at<shape>(f, squared));
}

template <KernelShape shape>
float at_places(const WeightedPlaces& places, const KernelBall& ball, float min_cosine) {
  const F f;
  const Vector3 position = set(ball.position), normal = set(ball.normal);
  const FloatVector inverse = hn::Set(f, ball.inverse_squared_radius), least = hn::Set(f, min_cosine);
  FloatVector sum = hn::Zero(f);
  for (std::size_t i = 0; i < places.count; i += hn::Lanes(f)) {
    const Vector3 from = minus(load(places.position, i), position);
    const FloatVector profile = profile_within<shape>(hn::Mul(dot(from, from), inverse));
    const auto counts = hn::And(hn::Gt(dot(load(places.normal, i), normal), least), hn::FirstN(f, places.count - i));
    sum = hn::Add(sum, hn::IfThenElseZero(counts, hn::Mul(hn::LoadU(f, places.weight + i), profile)));
  }
  return hn::GetLane(hn::SumOfLanes(f, sum));
}

template <KernelShape shape>
float on_plane(const float* x, const float* y, std::size_t count, const KernelBall& ball) {
  const F f;
  const FloatVector px = hn::Set(f, ball.position[0]), py = hn::Set(f, ball.position[1]);
  const FloatVector sx = hn::Set(f, -ball.normal[0] / ball.normal[2]),
                    sy = hn::Set(f, -ball.normal[1] / ball.normal[2]);
  const FloatVector inverse = hn::Set(f, ball.inverse_squared_radius);
  FloatVector sum = hn::Zero(f);
  for (std::size_t i = 0; i < count; i += hn::Lanes(f)) {
    const FloatVector dx = hn::Sub(hn::LoadU(f, x + i), px), dy = hn::Sub(hn::LoadU(f, y + i), py);
    const FloatVector dz = hn::MulAdd(dx, sx, hn::Mul(dy, sy));
    const FloatVector squared = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    const FloatVector profile = profile_within<shape>(hn::Mul(squared, inverse));
    sum = hn::Add(sum, hn::IfThenElseZero(hn::FirstN(f, count - i), profile));
  }
  return hn::GetLane(hn::SumOfLanes(f, sum));
}

float places_of(KernelShape shape, const WeightedPlaces& places, const KernelBall& ball, float min_cosine) {
  float sum = 0;
  with_kernel_shape(shape, [&](auto s) HWY_ATTR { sum = at_places<decltype(s)::value>(places, ball, min_cosine); });
  return sum;
}

float plane_of(KernelShape shape, const float* x, const float* y, std::size_t count, const KernelBall& ball) {
  float sum = 0;
  with_kernel_shape(shape, [&](auto s) HWY_ATTR { sum = on_plane<decltype(s)::value>(x, y, count, ball); });
  return sum;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(hits);
HWY_EXPORT(places_of);
HWY_EXPORT(plane_of);
}  // namespace

std::size_t segment_hits(const SegmentArrays& segments, const CornerAndEdges& triangle, float first,
                         std::uint32_t* segment, float* distance) {
  return HWY_DYNAMIC_DISPATCH(hits)(segments, triangle, first, segment, distance);
}

float sum_at_places(KernelShape shape, const WeightedPlaces& places, const KernelBall& ball, float min_cosine) {
  return HWY_DYNAMIC_DISPATCH(places_of)(shape, places, ball, min_cosine);
}

float sum_on_plane(KernelShape shape, const float* x, const float* y, std::size_t count, const KernelBall& ball) {
  return HWY_DYNAMIC_DISPATCH(plane_of)(shape, x, y, count, ball);
}

}  // namespace glowworm
#endif  // HWY_ONCE
