#include "builtin/mesh_builder.h"

#include <algorithm>

namespace glowworm {

std::uint32_t MeshBuilder::vertex(Vec3 position, Vec3 normal, Vec2 uv) {
  geometry_.positions.push_back(transform_.point(position));
  const Vec3 n = transform_.normal(normal);
  geometry_.normals.push_back(length_squared(n) > 0 ? normalize(n) : Vec3{0, 0, 0});
  geometry_.uvs.push_back(uv);
  return static_cast<std::uint32_t>(geometry_.positions.size() - 1);
}

void MeshBuilder::face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  geometry_.triangles.push_back({a, b, c});
  geometry_.material.push_back(material_);
  geometry_.emission.push_back(emission_);
}

void MeshBuilder::triangle(Vec3 a, Vec3 b, Vec3 c) {
  const std::uint32_t i = vertex(a, {0, 0, 0}, {0, 0});
  vertex(b, {0, 0, 0}, {1, 0});
  vertex(c, {0, 0, 0}, {0, 1});
  face(i, i + 1, i + 2);
}

void MeshBuilder::quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  const std::uint32_t i = vertex(a, {0, 0, 0}, {0, 0});
  vertex(b, {0, 0, 0}, {1, 0});
  vertex(c, {0, 0, 0}, {1, 1});
  vertex(d, {0, 0, 0}, {0, 1});
  face(i, i + 1, i + 2);
  face(i, i + 2, i + 3);
}

void MeshBuilder::polygon(std::span<const Vec3> points) {
  if (points.size() < 3) return;
  const std::uint32_t first = vertex(points[0], {0, 0, 0}, {0, 0});
  for (std::size_t k = 1; k < points.size(); ++k) vertex(points[k], {0, 0, 0}, {0, 0});
  for (std::uint32_t k = 1; k + 1 < points.size(); ++k) face(first, first + k, first + k + 1);
}

void MeshBuilder::box(Vec3 a, Vec3 b, unsigned faces) {
  if (faces & kMinX) quad({a.x, a.y, a.z}, {a.x, a.y, b.z}, {a.x, b.y, b.z}, {a.x, b.y, a.z});
  if (faces & kMaxX) quad({b.x, a.y, b.z}, {b.x, a.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z});
  if (faces & kMinY) quad({a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, a.y, b.z}, {a.x, a.y, b.z});
  if (faces & kMaxY) quad({a.x, b.y, b.z}, {b.x, b.y, b.z}, {b.x, b.y, a.z}, {a.x, b.y, a.z});
  if (faces & kMinZ) quad({b.x, a.y, a.z}, {a.x, a.y, a.z}, {a.x, b.y, a.z}, {b.x, b.y, a.z});
  if (faces & kMaxZ) quad({a.x, a.y, b.z}, {b.x, a.y, b.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z});
}

void MeshBuilder::room(Vec3 min, Vec3 max) {
  const std::size_t first = geometry_.triangles.size();
  box(min, max);
  for (std::size_t t = first; t < geometry_.triangles.size(); ++t)
    std::swap(geometry_.triangles[t][1], geometry_.triangles[t][2]);
}

void MeshBuilder::sphere(Vec3 center, float radius, int segments, int rings, bool inside) {
  const auto point = [&](int segment, int ring) -> Vec3 {
    if (ring == 0) return {0, -1, 0};
    if (ring == rings) return {0, 1, 0};
    const float theta = kPi * static_cast<float>(ring) / static_cast<float>(rings);
    const float phi = 2 * kPi * static_cast<float>(segment) / static_cast<float>(segments);
    return {std::sin(theta) * std::cos(phi), -std::cos(theta), -std::sin(theta) * std::sin(phi)};
  };
  const auto add = [&](int segment, int ring) {
    const Vec3 n = point(segment % segments, ring);
    return vertex(center + n * radius, inside ? -n : n,
                  {static_cast<float>(segment) / static_cast<float>(segments),
                   static_cast<float>(ring) / static_cast<float>(rings)});
  };
  const std::size_t first = geometry_.triangles.size();
  std::vector<std::uint32_t> below, row;
  for (int ring = 0; ring <= rings; ++ring) {
    row.clear();
    for (int segment = 0; segment <= segments; ++segment) row.push_back(add(segment, ring));
    for (std::size_t s = 0; ring > 0 && s < static_cast<std::size_t>(segments); ++s) {
      if (ring > 1) face(below[s], below[s + 1], row[s]);
      if (ring < rings) face(below[s + 1], row[s + 1], row[s]);
    }
    below = row;
  }
  if (inside)
    for (std::size_t t = first; t < geometry_.triangles.size(); ++t)
      std::swap(geometry_.triangles[t][1], geometry_.triangles[t][2]);
}

namespace {

// The outward normal of an outline's piece in the (radius, y) half-plane.
Vec2 piece_normal(const MeshBuilder::ProfilePoint& a, const MeshBuilder::ProfilePoint& b) {
  const float dr = b.radius - a.radius, dy = b.y - a.y;
  const float l = std::sqrt(dr * dr + dy * dy);
  return {dy / l, -dr / l};
}

Vec2 joined_normal(Vec2 a, Vec2 b) {
  const Vec2 sum = a + b;
  const float l = std::sqrt(sum.x * sum.x + sum.y * sum.y);
  return l > 1e-6f ? sum * (1 / l) : a;
}

}  // namespace

void MeshBuilder::lathe(std::span<const ProfilePoint> profile, int segments, float arc_begin, float arc_end) {
  const bool whole = std::abs(arc_end - arc_begin - 2 * kPi) < 1e-5f;
  const auto direction = [&](int segment) -> Vec3 {
    if (whole && segment == segments) segment = 0;
    const float phi = arc_begin + (arc_end - arc_begin) * static_cast<float>(segment) / static_cast<float>(segments);
    return {std::cos(phi), 0, -std::sin(phi)};
  };
  for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
    const ProfilePoint &a = profile[k], &b = profile[k + 1];
    const Vec2 flat = piece_normal(a, b);
    const Vec2 na = k > 0 && !a.crease ? joined_normal(flat, piece_normal(profile[k - 1], a)) : flat;
    const Vec2 nb = k + 2 < profile.size() && !b.crease ? joined_normal(flat, piece_normal(b, profile[k + 2])) : flat;
    std::uint32_t previous = 0;
    for (int s = 0; s <= segments; ++s) {
      const Vec3 d = direction(s);
      const float u = static_cast<float>(s) / static_cast<float>(segments);
      const std::uint32_t i = vertex({d.x * a.radius, a.y, d.z * a.radius}, {d.x * na.x, na.y, d.z * na.x}, {u, a.y});
      vertex({d.x * b.radius, b.y, d.z * b.radius}, {d.x * nb.x, nb.y, d.z * nb.x}, {u, b.y});
      if (s > 0 && a.radius > 0) face(previous, i, previous + 1);
      if (s > 0 && b.radius > 0) face(i, i + 1, previous + 1);
      previous = i;
    }
  }
}

void MeshBuilder::patch(const std::function<Vec3(float, float)>& surface, int nu, int nv) {
  const float du = 1.0f / static_cast<float>(nu), dv = 1.0f / static_cast<float>(nv);
  const std::uint32_t first = static_cast<std::uint32_t>(geometry_.positions.size());
  const std::uint32_t stride = static_cast<std::uint32_t>(nu) + 1;
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i) {
      const float u = static_cast<float>(i) * du, v = static_cast<float>(j) * dv;
      // A border may shrink to a point, so tangents are taken a little inside it.
      const float iu = std::clamp(u, du / 100, 1 - du / 100), iv = std::clamp(v, dv / 100, 1 - dv / 100);
      const Vec3 along_u = surface(std::min(iu + du / 2, 1.0f), iv) - surface(std::max(iu - du / 2, 0.0f), iv);
      const Vec3 along_v = surface(iu, std::min(iv + dv / 2, 1.0f)) - surface(iu, std::max(iv - dv / 2, 0.0f));
      const Vec3 normal = cross(along_u, along_v);
      vertex(surface(u, v), length_squared(normal) > 0 ? normalize(normal) : normal, {u, v});
    }
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(nv); ++j)
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(nu); ++i) {
      const std::uint32_t a = first + j * stride + i;
      const auto same = [&](std::uint32_t p, std::uint32_t q) {
        return geometry_.positions[p] == geometry_.positions[q];
      };
      if (!same(a, a + 1)) face(a, a + 1, a + stride + 1);
      if (!same(a + stride + 1, a + stride)) face(a, a + stride + 1, a + stride);
    }
}

void MeshBuilder::frame(const Vec3 (&outer)[4], const Vec3 (&hole)[4]) {
  for (int k = 0; k < 4; ++k) quad(outer[k], outer[(k + 1) % 4], hole[(k + 1) % 4], hole[k]);
}

void MeshBuilder::tube(const std::function<Vec3(float)>& center, const std::function<float(float)>& radius,
                       Vec3 reference, int around, int along) {
  patch(
      [&](float u, float v) {
        const float t = v;
        const Vec3 tangent = normalize(center(std::min(t + 0.01f, 1.0f)) - center(std::max(t - 0.01f, 0.0f)));
        const Vec3 a = normalize(cross(reference, tangent)), b = cross(tangent, a);
        const float angle = 2 * kPi * (u >= 1 ? 0 : u), r = radius(t);
        return center(t) + a * (r * std::cos(angle)) + b * (r * std::sin(angle));
      },
      around, along);
}

void MeshBuilder::instance(const Geometry& mesh) {
  const std::uint32_t base = static_cast<std::uint32_t>(geometry_.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) vertex(mesh.positions[v], mesh.normals[v], mesh.uvs[v]);
  for (const auto& [a, b, c] : mesh.triangles) face(base + a, base + b, base + c);
}

Transform place(Vec3 offset, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return {{c, 0, -s}, {0, 1, 0}, {s, 0, c}, offset};
}

}  // namespace glowworm
