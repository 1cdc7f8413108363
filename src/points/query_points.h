// Query points (the "reverse photons" of [HHS05]): where the photon map is looked up.
#pragma once
#include <cstdint>

#include "bsdf/bsdf.h"
#include "core/rgb.h"
#include "core/vec.h"
#include "points/batch.h"

namespace glowworm {

/// Value of QueryPoints::bsdf for Lambertian points.
inline constexpr std::uint32_t kLambertianQuery = 0xffffffffu;

/// A BSDF with its shading frame, for query points that are not Lambertian.
struct QueryBsdf {
  Bsdf bsdf;
  Vec3 s, t, n;          ///< shading frame in world space
  Vec3 wo;               ///< unit, world space, towards the gather point, by ShadedSurface::seen_from()
  Lobes lobes = kBroad;  ///< of the BSDF that scatter the photons
};

/// Points whose outgoing radiance is estimated. Arrays of one length, index i one point. Completion reads `weight` and
/// `gather_point`; the engines read the others.
struct QueryPoints : Batch<QueryPoints> {
  LargeVector<Vec3> position;               ///< metres
  LargeVector<Vec3> normal;                 ///< unit, geometric, on the visible side
  LargeVector<RGB> reflectance;             ///< Lambertian: albedo; others: unused
  LargeVector<std::uint32_t> bsdf;          ///< index into bsdfs, or kLambertianQuery
  LargeVector<QueryBsdf> bsdfs;             ///< one for each point that is not Lambertian
  LargeVector<RGB> weight;                  ///< f_r cos / (pdf N) at the gather point: factor on the radiance
  LargeVector<std::uint32_t> gather_point;  ///< the gather point (or any other target index) of this point

  /// Those with an element a point.
  template <class Any>
  static auto arrays(Any& points) {
    return std::tie(points.position, points.normal, points.reflectance, points.bsdf, points.weight,
                    points.gather_point);
  }
  void clear();
  void push_back(Vec3 p, Vec3 n, RGB albedo, RGB w, std::uint32_t target) {
    add(p, n, albedo, kLambertianQuery, w, target);
  }
  void push_back(Vec3 p, Vec3 n, const QueryBsdf& b, RGB w, std::uint32_t target);
  void append(const QueryPoints& other);
};

}  // namespace glowworm
