#include "import/pbrt/tessellation.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace glowworm {

namespace {

/// A point of a surface given by u and v in [0, 1].
struct SurfaceSample {
  Vec3 position, normal;
};

/// Adds a grid of columns x rows cells over [0, 1]^2, two triangles each. The winding is counter-clockwise seen from
/// the side of dp/du x dp/dv.
void append_grid(int columns, int rows, const std::function<SurfaceSample(float u, float v)>& surface,
                 Geometry& geometry) {
  const auto first = static_cast<std::uint32_t>(geometry.positions.size());
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const float u = static_cast<float>(i) / columns, v = static_cast<float>(j) / rows;
      const SurfaceSample sample = surface(u, v);
      geometry.positions.push_back(sample.position);
      geometry.normals.push_back(sample.normal);
      geometry.uvs.push_back({u, v});
    }
  }
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(j * (columns + 1) + i); };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    // At a pole, one side of the cell is a point.
    const Vec3 pa = geometry.positions[a], pb = geometry.positions[b], pc = geometry.positions[c];
    if (!(pa == pb) && !(pb == pc) && !(pc == pa)) geometry.triangles.push_back({a, b, c});
  };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
}

double area_of(const Geometry& geometry) {
  double sum = 0;
  for (std::uint32_t t = 0; t < geometry.triangles.size(); ++t) {
    const auto& [a, b, c] = geometry.triangles[t];
    const Vec3 p = geometry.positions[a], q = geometry.positions[b], r = geometry.positions[c];
    const double ux = double{q.x} - p.x, uy = double{q.y} - p.y, uz = double{q.z} - p.z;
    const double vx = double{r.x} - p.x, vy = double{r.y} - p.y, vz = double{r.z} - p.z;
    const double x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    sum += std::sqrt(x * x + y * y + z * z) / 2;
  }
  return sum;
}

/// Number of cells for an angle of phi_max, if a full circle has `full`.
int cells_around(float phi_max, int full) {
  return std::max(3, static_cast<int>(std::ceil(full * phi_max / (2 * kPi))));
}

/// Cosine and sine of u * phi_max. The ends of a full circle are bitwise equal.
Vec2 on_circle(float u, float phi_max) {
  if (u == 1 && phi_max >= 2 * kPi) u = 0;
  const double phi = static_cast<double>(u) * phi_max;
  return {static_cast<float>(std::cos(phi)), static_cast<float>(std::sin(phi))};
}

}  // namespace

PbrtMesh tessellate_sphere(float radius, float z_min, float z_max, float phi_max, bool fine) {
  const double theta_min = std::acos(std::clamp(static_cast<double>(z_min) / radius, -1.0, 1.0));
  const double theta_max = std::acos(std::clamp(static_cast<double>(z_max) / radius, -1.0, 1.0));
  const int full = fine ? 128 : 64;
  const int columns = cells_around(phi_max, full);
  const int rows = std::max(2, static_cast<int>(std::ceil(full / 2 * (theta_min - theta_max) / M_PI)));
  PbrtMesh mesh;
  append_grid(
      columns, rows,
      [&](float u, float v) -> SurfaceSample {
        const double theta = theta_min + v * (theta_max - theta_min);
        // The poles are bitwise equal points.
        const bool pole = (v == 0 && theta_min >= M_PI) || (v == 1 && theta_max <= 0);
        const auto s = pole ? 0.0f : static_cast<float>(std::sin(theta));
        const Vec2 c = on_circle(u, phi_max);
        const Vec3 normal{s * c.x, s * c.y, static_cast<float>(std::cos(theta))};
        return {normal * radius, normal};
      },
      mesh.geometry);
  const double true_area = static_cast<double>(phi_max) * radius * radius * (std::cos(theta_max) - std::cos(theta_min));
  const auto correction = static_cast<float>(std::sqrt(true_area / area_of(mesh.geometry)));
  if (std::isfinite(correction)) {
    for (Vec3& p : mesh.geometry.positions) p *= correction;
  }
  return mesh;
}

PbrtMesh tessellate_disk(float height, float radius, float inner_radius, float phi_max) {
  const int columns = cells_around(phi_max, 128);
  // A circular sector of angle a becomes a triangle of area r^2 sin(a) / 2 instead of r^2 a / 2.
  const double step = static_cast<double>(phi_max) / columns;
  const auto correction = static_cast<float>(std::sqrt(step / std::sin(step)));
  PbrtMesh mesh;
  append_grid(
      columns, 1,
      [&](float u, float v) -> SurfaceSample {
        const float r = (v == 0 ? radius : inner_radius) * correction;
        const Vec2 c = on_circle(u, phi_max);
        return {{r * c.x, r * c.y, height}, {0, 0, 1}};
      },
      mesh.geometry);
  return mesh;
}

PbrtMesh tessellate_cylinder(float radius, float z_min, float z_max, float phi_max) {
  const int columns = cells_around(phi_max, 128);
  const double half_step = static_cast<double>(phi_max) / columns / 2;
  const auto r = static_cast<float>(radius * half_step / std::sin(half_step));
  PbrtMesh mesh;
  append_grid(
      columns, 1,
      [&](float u, float v) -> SurfaceSample {
        const Vec2 c = on_circle(u, phi_max);
        return {{r * c.x, r * c.y, v == 0 ? z_min : z_max}, {c.x, c.y, 0}};
      },
      mesh.geometry);
  return mesh;
}

void append_bilinear_patch(const Vec3 (&corner)[4], const std::vector<Vec3>& normals, const std::vector<Vec2>& uvs,
                           PbrtMesh& mesh) {
  const auto mixed = [](const auto& value, float u, float v) {
    return (value[0] * (1 - u) + value[1] * u) * (1 - v) + (value[2] * (1 - u) + value[3] * u) * v;
  };
  const Vec3 along_u = corner[1] - corner[0], along_v = corner[2] - corner[0];
  const Vec3 cross_product = cross(along_u, along_v);
  const float out_of_plane = std::fabs(dot(cross_product, corner[3] - corner[0]));
  const float size = std::max(length(along_u), length(along_v));
  // Flat to one millionth of its size.
  const bool flat = out_of_plane <= 1e-6f * length(cross_product) * size;
  const int cells = flat ? 1 : 16;
  Geometry& geometry = mesh.geometry;
  const std::size_t first_vertex = geometry.positions.size(), first_triangle = geometry.triangles.size();
  append_grid(
      cells, cells,
      [&](float u, float v) -> SurfaceSample {
        const Vec3 p = mixed(corner, u, v);
        if (!normals.empty()) return {p, mixed(normals, u, v)};
        if (flat) return {p, {0, 0, 0}};
        const Vec3 du = (corner[1] - corner[0]) * (1 - v) + (corner[3] - corner[2]) * v;
        const Vec3 dv = (corner[2] - corner[0]) * (1 - u) + (corner[3] - corner[1]) * u;
        return {p, cross(du, dv)};
      },
      geometry);
  if (!uvs.empty()) {
    for (std::size_t i = first_vertex; i < geometry.uvs.size(); ++i) {
      geometry.uvs[i] = mixed(uvs, geometry.uvs[i].x, geometry.uvs[i].y);
    }
  }
  const std::uint32_t patch = mesh.patch.empty() ? 0 : mesh.patch.back() + 1;
  mesh.patch.insert(mesh.patch.end(), geometry.triangles.size() - first_triangle, patch);
}

}  // namespace glowworm
