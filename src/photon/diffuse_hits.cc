#include "photon/diffuse_hits.h"

#include "scene/surface.h"

namespace glowworm {

namespace {

/// Bits of a triangle's kind that must be set for the kernel.
constexpr std::uint32_t kServed = DiffuseTriangle::kDiffuse | DiffuseTriangle::kMapped;

/// Triangles that fit the second-level cache with the other data and need no prefetch.
constexpr std::size_t kTrianglesInCache = 2048;

/// Paths without a hit are treated as hits on a black surface: a branch would mispredict often.
constexpr DiffuseTriangle kNothing{{0, 0, 0}, {{0, 0, 0}, {0, 0, 0}},    {0, 0, 1},
                                   RGB(0.0f), DiffuseTriangle::kDiffuse, 0};

/// The kernel leaves no photon on a surface that reflects nothing, and ends paths that carry so little.
constexpr RGB kNearlyBlack(1e-38f);

}  // namespace

void DiffuseHits::place(const Scene& scene, std::span<const Hit> hits, std::size_t first, std::size_t count) {
  const auto put = [](Array* arrays, std::size_t i, Vec3 v) {
    for (int axis = 0; axis < 3; ++axis) arrays[axis][i] = v[axis];
  };
  const bool fetched = scene.geometry().triangle_count() > kTrianglesInCache;
  for (std::size_t i = 0; i < count; ++i) {
    if (fetched) fetch_ahead<true>(scene, first + i, hits.size(), [&](std::size_t at) { return hits[at].triangle; });
    const Hit& hit = hits[first + i];
    const bool missed = hit.triangle == kNone;
    DiffuseTriangleRoom room;
    const DiffuseTriangle& triangle = missed ? kNothing : scene.diffuse_triangle(hit.triangle, room);
    put(corner_, i, triangle.corner);
    put(edges_, i, triangle.edge[0]);
    put(edges_ + 3, i, triangle.edge[1]);
    put(geometric_, i, triangle.normal);
    offset_[i] = triangle.offset();
    const bool served = (triangle.kind & kServed) == DiffuseTriangle::kDiffuse;
    RGB reflectance = served ? triangle.reflectance : RGB(0.0f);
    const bool textured = served && triangle.kind & DiffuseTriangle::kTextured;
    if (textured) reflectance = diffuse_reflectance(scene, hit.triangle, hit.barycentric);
    // Estimates around a black texel reach over it.
    if ((textured || on_black_) && !missed && is_black(reflectance)) reflectance = kNearlyBlack;
    for (int c = 0; c < 3; ++c) reflectance_[c][i] = reflectance[c];
    barycentric_[0][i] = hit.barycentric.x;
    barycentric_[1][i] = hit.barycentric.y;
    other_[i] = !served;
    missed_[i] = -static_cast<std::uint32_t>(missed);
  }
}

void DiffuseHits::place_normals(const Geometry& geometry, const Hit* hits, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t triangle = hits[i].triangle == kNone ? 0 : hits[i].triangle;
    const std::array<Vec3, 3> normals = geometry.corner_normals(triangle);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3 normal = normals[corner];
      vertex_normals_[3 * corner][i] = normal.x;
      vertex_normals_[3 * corner + 1][i] = normal.y;
      vertex_normals_[3 * corner + 2][i] = normal.z;
    }
  }
}

void DiffuseHits::scatter(const Scene& scene, std::span<const Ray> rays, std::span<const Hit> hits, std::size_t first,
                          std::size_t count, const ArrivedPaths& paths) {
  place(scene, hits, first, count);
  // Otherwise they keep their initial zeros.
  if (scene.smooth()) place_normals(scene.geometry(), hits.data() + first, count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 direction = rays[first + i].direction;
    back_[0][i] = -direction.x;
    back_[1][i] = -direction.y;
    back_[2][i] = -direction.z;
  }
  ArrivedPaths arrived;
  arrived.count = count;
  arrived.offset = offset_;
  arrived.roulette = paths.roulette + first;
  for (std::size_t k = 0; k < 6; ++k) arrived.edges[k] = edges_[k];
  for (std::size_t k = 0; k < 9; ++k) arrived.vertex_normals[k] = vertex_normals_[k];
  for (std::size_t k = 0; k < 2; ++k) {
    arrived.barycentric[k] = barycentric_[k];
    arrived.square[k] = paths.square[k] + first;
  }
  ScatteredPaths scattered;
  scattered.outcome = outcome_;
  for (std::size_t k = 0; k < 3; ++k) {
    arrived.corner[k] = corner_[k];
    arrived.geometric[k] = geometric_[k];
    arrived.reflectance[k] = reflectance_[k];
    arrived.back[k] = back_[k];
    arrived.flux[k] = paths.flux[k] + first;
    scattered.position[k] = position_[k];
    scattered.normal[k] = normal_[k];
    scattered.photon_flux[k] = photon_flux_[k];
    scattered.origin[k] = origin_[k];
    scattered.direction[k] = direction_[k];
    scattered.flux[k] = flux_[k];
  }
  diffuse_scatter(arrived, scattered);
}

void DiffuseHits::put_photon(std::size_t i, Vec3 position, Vec3 normal, RGB flux) {
  for (int k = 0; k < 3; ++k) {
    position_[k][i] = position[k];
    normal_[k][i] = normal[k];
    photon_flux_[k][i] = flux[k];
  }
}

void DiffuseHits::put_back(std::size_t i, Vec3 back) {
  for (int k = 0; k < 3; ++k) back_[k][i] = back[k];
}

void DiffuseHits::put_path(std::size_t i, Vec3 origin, Vec3 direction, RGB flux) {
  for (int k = 0; k < 3; ++k) {
    origin_[k][i] = origin[k];
    direction_[k][i] = direction[k];
    flux_[k][i] = flux[k];
  }
}

}  // namespace glowworm
