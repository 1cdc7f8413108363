// Query points (the "reverse photons" of [HHS05]): where the photon map is looked up.
#pragma once
#include <cstdint>

#include "bsdf/bsdf.h"
#include "core/large_array.h"
#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm {

/// Value of QueryPoints::bsdf for Lambertian points.
inline constexpr std::uint32_t kLambertianQuery = 0xffffffffu;

/// A BSDF with its shading frame, for query points that are not Lambertian.
struct QueryBsdf {
  Bsdf bsdf;
  Vec3 s, t, n;  ///< shading frame in world space
  Vec3 wo;       ///< unit, world space, towards the gather point, by ShadedSurface::seen_from()
};

/// Points whose outgoing radiance is estimated. Arrays of one length, index i one point. Completion reads `weight` and
/// `gather_point`; the engines read the others.
struct QueryPoints {
  LargeVector<Vec3> position;               ///< metres
  LargeVector<Vec3> normal;                 ///< unit, geometric, on the visible side
  LargeVector<RGB> reflectance;             ///< Lambertian: albedo; others: unused
  LargeVector<std::uint32_t> bsdf;          ///< index into bsdfs, or kLambertianQuery
  LargeVector<QueryBsdf> bsdfs;             ///< one for each point that is not Lambertian
  LargeVector<RGB> weight;                  ///< f_r cos / (pdf N) at the gather point: factor on the radiance
  LargeVector<std::uint32_t> gather_point;  ///< the gather point (or any other target index) of this point

  std::size_t size() const { return position.size(); }
  /// Calls work(array of each...) for each of the arrays with an element a point.
  template <class Work, class... Points>
  static void for_arrays(const Work& work, Points&... points) {
    work(points.position...);
    work(points.normal...);
    work(points.reflectance...);
    work(points.bsdf...);
    work(points.weight...);
    work(points.gather_point...);
  }
  /// Removes all points but keeps their memory.
  void clear();
  /// Reserves memory for n points, but none for bsdfs.
  void reserve(std::size_t n);
  void push_back(Vec3 p, Vec3 n, RGB albedo, RGB w, std::uint32_t target) {
    position.push_back(p);
    normal.push_back(n);
    reflectance.push_back(albedo);
    bsdf.push_back(kLambertianQuery);
    weight.push_back(w);
    gather_point.push_back(target);
  }
  void push_back(Vec3 p, Vec3 n, const QueryBsdf& b, RGB w, std::uint32_t target);
  void append(const QueryPoints& other);
};

}  // namespace glowworm
