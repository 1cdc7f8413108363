// From a triangle and barycentric coordinates to everything that shading needs.
#pragma once
#include "bsdf/bsdf.h"
#include "bsdf/shaded_surface.h"
#include "core/frame.h"
#include "scene/scene.h"

namespace glowworm {

/// A point of a surface.
struct SurfacePoint {
  Vec3 position;          ///< metres
  Vec3 geometric_normal;  ///< unit, by the winding
  float offset = 0;       ///< how far along it, or against it, rays begin that leave (offset_origin()), metres
  Frame frame;            ///< shading frame: its n on the side of geometric_normal, s along the texture's u
  Vec2 uv;
  std::uint32_t triangle = kNone;
  std::uint32_t material = kNone;
};

/// @param barycentric weights of the second and third vertex
SurfacePoint surface_point(const Scene& scene, std::uint32_t triangle, Vec2 barycentric);

/// The material at a point, its textures evaluated. Applies normal and bump maps to point.frame, but for normals that
/// leave the side of the geometric one. Mixed materials are chosen by a hash of the position.
Bsdf resolve_bsdf(const Scene& scene, SurfacePoint& point);

/// The BSDF of a point, as viewers and lights in world space see it.
inline ShadedSurface shaded(const SurfacePoint& point, const Bsdf& bsdf) {
  return {bsdf, point.frame, point.geometric_normal};
}

/// The shading normal, or its opposite, on the side of the surface that wo (unit, world space) is on.
inline Vec3 shading_normal_towards(Vec3 shading_normal, Vec3 geometric_normal, Vec3 wo) {
  return dot(geometric_normal, wo) < 0 ? -shading_normal : shading_normal;
}

/// What a density estimate asks of a surface that only reflects diffusely.
struct DiffusePoint {
  Vec3 position;          ///< metres
  Vec3 geometric_normal;  ///< unit, by the winding
  RGB reflectance;
};

/// Reflectance of a triangle whose material is diffuse reflection alone, in [0, 1].
RGB diffuse_reflectance(const Scene& scene, std::uint32_t triangle, Vec2 barycentric);

/// Where the triangle's material is diffuse reflection alone, fills `point` with the numbers that surface_point() and
/// resolve_bsdf() would give, at a fraction of their cost, and returns true; else returns false.
inline bool diffuse_point(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, DiffusePoint& point) {
  const DiffuseTriangle& t = scene.diffuse_triangle(triangle);
  if (!(t.kind & DiffuseTriangle::kDiffuse)) return false;
  point.position = t.corner + t.edge[0] * barycentric.x + t.edge[1] * barycentric.y;
  point.geometric_normal = t.normal;
  point.reflectance =
      t.kind & DiffuseTriangle::kTextured ? diffuse_reflectance(scene, triangle, barycentric) : t.reflectance;
  return true;
}

/// The shading normal that surface_point() and resolve_bsdf() would give where no map turns it, at a fraction of their
/// cost: unit, on the side of point.geometric_normal. Returns false where there is a map.
/// @param point diffuse_point() of the same place
bool diffuse_shading_normal(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, const DiffusePoint& point,
                            Vec3& normal);

/// Asks the processor for what surface_point() and diffuse_point() read, since hits of incoherent rays lie all over the
/// scene: each hit is fetched in three steps, kFetchAhead hits apart, that read what the one before has fetched; the
/// last two only where diffuse_point() is not enough. Called with `next` from 0 on before hit `next` is used, it has
/// fetched that hit in time.
/// @tparam kSmoothToo whether shading normals are asked for, too
/// @param triangle_of the triangle of hit i, or kNone
// Inlined, since GCC takes a function that only prefetches for one without effect, and drops its calls.
template <bool kSmoothToo, typename TriangleOf>
[[gnu::always_inline]] inline void fetch_ahead(const Scene& scene, std::size_t next, std::size_t count,
                                               TriangleOf&& triangle_of) {
  constexpr std::size_t kFetchAhead = 8;
  constexpr std::uint32_t kOverlooked = kSmoothToo ? 0 : DiffuseTriangle::kSmooth;
  const Geometry& g = scene.geometry();
  if (next + 3 * kFetchAhead < count)
    if (const std::uint32_t triangle = triangle_of(next + 3 * kFetchAhead); triangle != kNone)
      __builtin_prefetch(&scene.diffuse_triangle(triangle));
  const auto needs_more = [&](std::uint32_t triangle) {
    return triangle != kNone && (scene.diffuse_triangle(triangle).kind & ~kOverlooked) != DiffuseTriangle::kDiffuse;
  };
  if (next + 2 * kFetchAhead < count) {
    if (const std::uint32_t triangle = triangle_of(next + 2 * kFetchAhead); needs_more(triangle)) {
      __builtin_prefetch(&g.triangles[triangle]);
      __builtin_prefetch(&g.material[triangle]);
      __builtin_prefetch(&g.emission[triangle]);
    }
  }
  if (next + kFetchAhead < count) {
    if (const std::uint32_t triangle = triangle_of(next + kFetchAhead); needs_more(triangle))
      for (const std::uint32_t vertex : g.triangles[triangle]) {
        __builtin_prefetch(&g.positions[vertex]);
        __builtin_prefetch(&g.normals[vertex]);
      }
  }
}

/// Radiance (W sr^-1 m^-2) that the surface itself emits towards wo; black where it is no emitter or seen from behind.
RGB emitted_radiance(const Scene& scene, const SurfacePoint& point, Vec3 wo);

/// Whether an alpha-tested surface is there for the ray: by the cut-off, or by chance that depends on the ray alone.
bool alpha_present(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, Vec3 ray_origin, Vec3 ray_direction);

}  // namespace glowworm
