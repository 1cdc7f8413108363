#include "kernels/diffuse_rays.h"

#include "core/random.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/diffuse_rays.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "kernels/warp-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t kLanes = hn::MaxLanes(SobolTag());
static_assert(kLanes <= kDiffuseRayPadding);

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
