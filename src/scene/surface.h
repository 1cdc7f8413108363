// Computes shading data from a triangle and barycentric coordinates.
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
  float offset =
      0;        ///< distance along the normal, or against it, at which leaving rays start (offset_origin()), metres
  Frame frame;  ///< shading frame: its n on the side of geometric_normal, s along the texture's u
  TexturePoint texture;  ///< texture coordinates and position for texture lookups
  std::uint32_t triangle = kNone;
  std::uint32_t material = kNone;
};

/// The middle of a triangle, by the weights of its second and third vertex.
inline constexpr Vec2 kMiddle{1.0f / 3, 1.0f / 3};

/// @param barycentric weights of the second and third vertex
SurfacePoint surface_point(const Scene& scene, std::uint32_t triangle, Vec2 barycentric);

/// The material at a point, its textures evaluated. Applies normal and bump maps to point.frame unless the normal would
/// leave the side of the geometric one. A hash of the position chooses between mixed materials.
Bsdf resolve_bsdf(const Scene& scene, SurfacePoint& point);

/// The BSDF of a point, for directions in world space.
inline ShadedSurface shaded(const SurfacePoint& point, const Bsdf& bsdf) {
  return {bsdf, point.frame, point.geometric_normal};
}

/// The shading normal, or its opposite, on the side of wo (unit, world space).
inline Vec3 shading_normal_towards(Vec3 shading_normal, Vec3 geometric_normal, Vec3 wo) {
  return dot(geometric_normal, wo) < 0 ? -shading_normal : shading_normal;
}

/// Data of a purely diffuse surface for density estimation.
struct DiffusePoint {
  Vec3 position;          ///< metres
  Vec3 geometric_normal;  ///< unit, by the winding
  RGB reflectance;
};

/// Reflectance of a triangle whose material is diffuse reflection only, in [0, 1].
RGB diffuse_reflectance(const Scene& scene, std::uint32_t triangle, Vec2 barycentric);

/// If the triangle's material is diffuse reflection only, fills `point` with the numbers of surface_point() and
/// resolve_bsdf(), at a fraction of their cost, and returns true; otherwise returns false.
inline bool diffuse_point(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, DiffusePoint& point) {
  DiffuseTriangleRoom room;
  const DiffuseTriangle& t = scene.diffuse_triangle(triangle, room);
  if (!(t.kind & DiffuseTriangle::kDiffuse)) return false;
  point.position = t.corner + t.edge[0] * barycentric.x + t.edge[1] * barycentric.y;
  point.geometric_normal = t.normal;
  point.reflectance =
      t.kind & DiffuseTriangle::kTextured ? diffuse_reflectance(scene, triangle, barycentric) : t.reflectance;
  return true;
}

/// The shading normal of surface_point() and resolve_bsdf() if no map changes it, at a fraction of their cost: unit, on
/// the side of point.geometric_normal. Returns false if there is a map.
/// @param point diffuse_point() of the same place
bool diffuse_shading_normal(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, const DiffusePoint& point,
                            Vec3& normal);

/// Radiance (W sr^-1 m^-2) that the surface emits towards wo; black if it does not emit or wo is behind it.
RGB emitted_radiance(const Scene& scene, const SurfacePoint& point, Vec3 wo);

/// Share of the light that comes straight through a surface from behind it: where it is absent, and where it is a pane.
/// @param direction of a ray towards the light, unit
RGB straight_transmittance(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, Vec3 direction);

/// Share of rays for which a surface is present at a point: 1, or by its alpha.
float coverage(const Scene& scene, std::uint32_t triangle, const TexturePoint& at);

/// Whether a surface is present for a ray: by a random number that depends only on the ray.
/// @param coverage coverage() where the ray meets it
bool is_present(float coverage, std::uint32_t triangle, Vec3 ray_origin, Vec3 ray_direction);

}  // namespace glowworm
