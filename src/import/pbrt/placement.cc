#include "import/pbrt/placement.h"

#include <utility>

namespace glowworm {

namespace {

void wind_outwards(Geometry& mesh, bool swap_all) {
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    auto& [a, b, c] = mesh.triangles[t];
    bool swap = swap_all;
    if (!mesh.normals.empty()) {
      const auto unit = [&](std::uint32_t vertex) {
        const Vec3 n = mesh.normals[vertex];
        const float l = length(n);
        return l > 0 ? n / l : Vec3{0, 0, 0};
      };
      const float side = dot(mesh.scaled_normal(t), unit(a) + unit(b) + unit(c));
      if (side != 0) swap = side < 0;
    }
    if (swap) std::swap(b, c);
  }
}

/// Adds pbrt's default texture coordinates.
/// @param patch of each triangle: two of one patch are a quad; empty: each is a triangle
void add_default_uvs(Geometry& mesh, const std::vector<std::uint32_t>& patch) {
  constexpr Vec2 kCorner[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  constexpr int kTriangle[3] = {0, 1, 2}, kSecondHalf[3] = {0, 2, 3};
  constexpr int kOtherFirstHalf[3] = {0, 1, 3}, kOtherSecondHalf[3] = {1, 2, 3};
  const auto share = [&](std::size_t a, std::size_t b) {
    return a < patch.size() && b < patch.size() && patch[a] == patch[b];
  };
  Geometry out;
  const std::size_t count = mesh.triangles.size() * 3;
  out.positions.reserve(count);
  out.uvs.reserve(count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    const bool first_half = share(t, t + 1) && !share(t, t + 2) && !share(t, t - 1);
    const bool second_half = share(t, t - 1) && !share(t, t - 2) && !share(t, t + 1);
    const int* which = kTriangle;
    if (first_half && corners[0] != mesh.triangles[t + 1][0]) which = kOtherFirstHalf;
    if (second_half) which = corners[0] == mesh.triangles[t - 1][0] ? kSecondHalf : kOtherSecondHalf;
    const auto first = static_cast<std::uint32_t>(out.positions.size());
    for (int i = 0; i < 3; ++i) {
      out.positions.push_back(mesh.positions[corners[i]]);
      if (!mesh.normals.empty()) out.normals.push_back(mesh.normals[corners[i]]);
      out.uvs.push_back(kCorner[which[i]]);
    }
    out.triangles.push_back({first, first + 1, first + 2});
  }
  mesh = std::move(out);
}

/// Index of each triangle's emission.
std::vector<std::uint32_t> emissions_of(PbrtContext& context, const PbrtShape& shape, const Geometry& world) {
  std::vector<double> areas(1, 0.0);
  const auto patch_of = [&](std::size_t t) { return shape.mesh.patch.empty() ? 0u : shape.mesh.patch[t]; };
  for (std::size_t t = 0; t < world.triangles.size(); ++t) {
    const std::uint32_t patch = patch_of(t);
    if (patch >= areas.size()) areas.resize(patch + 1, 0.0);
    areas[patch] += world.area(static_cast<std::uint32_t>(t));
  }
  std::vector<std::uint32_t> of_patch(areas.size(), kNone), out(world.triangles.size());
  for (std::size_t t = 0; t < out.size(); ++t) {
    std::uint32_t& emission = of_patch[patch_of(t)];
    if (emission == kNone) emission = add_emission(context, *shape.light, areas[patch_of(t)]);
    out[t] = emission;
  }
  return out;
}

}  // namespace

Geometry to_world_space(const PbrtShape& shape, const TransformDouble& to_world, CoordinateOrigin& origin) {
  TransformDouble exact = to_world * shape.to_outer;
  exact.translation = exact.point(Vec3d(shape.mesh.origin));
  const Transform total = exact.relative_to(origin.origin());
  Geometry mesh = shape.mesh.geometry;
  if (mesh.uvs.empty() && shape.textured) add_default_uvs(mesh, shape.mesh.patch);
  for (Vec3& p : mesh.positions) p = origin.take(exact.point(Vec3d(p)));
  for (Vec3& n : mesh.normals) n = shape.reverse ? -total.normal(n) : total.normal(n);
  wind_outwards(mesh, shape.reverse != (total.determinant() < 0));
  return mesh;
}

SharedMesh shared_mesh(const std::vector<PbrtShape>& shapes) {
  CoordinateOrigin origin;
  Geometry mesh = read_near(origin, [&] {
    Geometry all;
    for (const PbrtShape& shape : shapes)
      append_mesh(all, to_world_space(shape, TransformDouble(), origin), shape.kind.c_str(), shape.material, kNone);
    return all;
  });
  return {std::move(mesh), Vec3d(origin.origin())};
}

void place_shape(PbrtContext& context, const PbrtShape& shape, const TransformDouble& to_world) {
  Geometry world = to_world_space(shape, to_world, context.origin);
  if (shape.light) world.emission = emissions_of(context, shape, world);
  context.scene.geometry.begin_object(
      shape.name.empty() ? shape.kind + " " + std::to_string(context.scene.geometry.objects.size() + 1) : shape.name);
  const AppendResult result = append_mesh(context.scene.geometry, world, shape.kind.c_str(), shape.material, kNone);
  if (result.degenerate > 0) {
    context.diagnostics.note(shape.place, "left out: triangles without area of a " + shape.kind, result.degenerate);
  }
  if (result.not_finite > 0) {
    context.diagnostics.note(shape.place, "left out: triangles with infinite corners of a " + shape.kind,
                             result.not_finite);
  }
}

}  // namespace glowworm
