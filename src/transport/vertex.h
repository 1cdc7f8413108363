// Surfaces where paths scatter, the fast path for diffuse ones, and both as gather and query points.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/vec.h"
#include "points/gather_points.h"
#include "points/query_points.h"
#include "scene/surface.h"
#include "transport/path_state.h"

namespace glowworm {

/// A surface where a path scatters.
struct Vertex {
  SurfacePoint point;
  Vec3 wo;  ///< unit, back along the path
  Bsdf bsdf;
  float time = 0;       ///< of the path, as Ray::time
  MediumSides media{};  ///< in scenes with media

  /// The BSDF in world space. The vertex must outlive it.
  ShadedSurface surface() const { return shaded(point, bsdf); }
  /// The geometric normal on the side of wo.
  Vec3 normal() const { return face_forward(point.geometric_normal, wo); }
  bool has(Lobes which) const { return (lobes(bsdf) & which) != 0; }
};

/// A vertex at the hit of a ray of unit direction, without its material.
inline Vertex vertex_at(const Scene& scene, const Ray& ray, const Hit& hit) {
  return {surface_point(scene, hit.triangle, hit.barycentric), -ray.direction, {}, ray.time};
}

/// Resolves the material of a vertex. Where it disperses, chooses a wavelength.
/// @param number gives a random number in [0, 1); called only then
template <typename Number>
void resolve_material(const Scene& scene, Vertex& vertex, RGB& throughput, Number&& number) {
  vertex.bsdf = resolve_bsdf(scene, vertex.point);
  if (vertex.bsdf.dispersion > 0) throughput *= choose_wavelength(vertex.bsdf, throughput, number());
}

/// The probability with which a path takes the broad lobes of a vertex and not the specular ones: by their albedos.
float broad_probability(const Vertex& vertex);

/// The specular lobes of a vertex if all of them are perfectly smooth, with what each of them passes on; none
/// otherwise.
struct SmoothLobes {
  std::array<ScatteredRay, 2> ray;
  std::size_t count = 0;
};
SmoothLobes smooth_lobes(const Vertex& vertex);

/// If a ray has hit a surface that emits nothing and only reflects diffusely, as most do, fills `point` at a fraction
/// of the cost of a Vertex, and returns true; otherwise returns false.
inline bool diffuse_vertex(const Scene& scene, const Hit& hit, DiffusePoint& point) {
  DiffuseTriangleRoom room;
  return !(scene.diffuse_triangle(hit.triangle, room).kind & DiffuseTriangle::kEmits) &&
         diffuse_point(scene, hit.triangle, hit.barycentric, point);
}

/// Appends a surface point as query points: one; two if it transmits light diffusely; none if it is black.
/// @param target QueryPoints::gather_point @param lobes those that scatter the photons
void add_query(QueryPoints& queries, const Vertex& vertex, RGB weight, std::uint32_t target, Lobes lobes = kBroad);
/// The same for diffuse_vertex(). @param wo as Vertex::wo
inline void add_query(QueryPoints& queries, const DiffusePoint& point, Vec3 wo, RGB weight, std::uint32_t target) {
  if (!is_black(point.reflectance))
    queries.push_back(point.position, face_forward(point.geometric_normal, wo), point.reflectance, weight, target);
}

/// Appends a vertex to the gather points. @param slot, sequence, sample, throughput as the members of GatherPoints
/// @param in_media whether the scene has media
void add_gather_point(GatherPoints& points, const Vertex& vertex, RGB throughput, std::uint32_t slot,
                      std::uint32_t sequence, std::uint32_t sample, bool in_media);
/// A gather point as a vertex, of no triangle.
Vertex vertex_of(const GatherPoints& points, std::size_t i);
/// The gather points as query points for the caustic map, weighted by the throughput.
QueryPoints gather_points_as_queries(const GatherPoints& points);

}  // namespace glowworm
