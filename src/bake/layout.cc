#include "bake/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "bake/light.h"
#include "control/job.h"
#include "core/error.h"
#include "core/memory_budget.h"
#include "core/offset_origin.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/warp.h"

namespace glowworm {

namespace {

/// Share of the rays from a place that meet something, and that meet the back of something.
struct Surroundings {
  float met = 0, backs = 0;
};

constexpr std::uint32_t kRays = 16;

/// Looks around from a point by some of kRays rays. The same rays for the same number.
/// @param roofs triangles whose backs do not count as such; empty: none
Surroundings look_around(const Scene& scene, const Tracer& tracer, Vec3 position, Vec3 normal, std::uint32_t number,
                         std::uint32_t rays = kRays, std::span<const std::uint8_t> roofs = {}) {
  const Frame frame = Frame::from_normal(normal);
  Surroundings out;
  for (std::uint32_t i = 0; i < rays; ++i) {
    const std::uint32_t key = hash_combine(number, i), cell = i * 7 % kRays;
    const Vec2 u{(static_cast<float>(cell % 4) + to_unit_float(hash_combine(key, 1))) / 4,
                 (static_cast<float>(cell / 4) + to_unit_float(hash_combine(key, 2))) / 4};
    const Vec3 direction = frame.to_world(square_to_cosine_hemisphere(u));
    const Hit hit = tracer.intersect({position, 0, direction, std::numeric_limits<float>::infinity()});
    if (hit.triangle == kNone) continue;
    out.met += 1.0f / static_cast<float>(rays);
    const bool is_roof = !roofs.empty() && roofs[hit.triangle];
    const bool is_back = !is_roof && dot(scene.geometry().normal(hit.triangle), direction) > 0;
    out.backs += is_back ? 1.0f / static_cast<float>(rays) : 0;
  }
  return out;
}

/// Where rays begin that leave the side of a surface that `normal` points to.
Vec3 ray_origin(const SurfacePoint& point, Vec3 normal) {
  return point.position + normal * std::max(point.offset * 4, 1e-6f * length(point.position));
}

/// Whether the two sides of some faces may be seen and lit.
struct OpenSides {
  bool front = true, back = false;
  float behind = 0;  ///< share of the back's surroundings that are surfaces
};

/// Looks around from a few dozen places of connected triangles. The inside of a solid meets only backs; the outside of
/// a room meets nothing, but lights without a surface may be there.
OpenSides open_sides(const Scene& scene, const Tracer& tracer, const std::vector<std::uint32_t>& triangles) {
  constexpr std::size_t kMaxPlaces = 32;
  constexpr float kSolid = 0.98f, kSomething = 0.02f;
  Surroundings sum[2];
  const std::size_t places = std::min(kMaxPlaces, triangles.size());
  for (std::size_t i = 0; i < places; ++i) {
    const std::uint32_t triangle = triangles[i * triangles.size() / places];
    const SurfacePoint point = surface_point(scene, triangle, {1 / 3.0f, 1 / 3.0f});
    if (!(length_squared(point.geometric_normal) > 0)) continue;
    for (int side = 0; side < 2; ++side) {
      const Vec3 n = side == 0 ? point.geometric_normal : -point.geometric_normal;
      const Surroundings seen = look_around(scene, tracer, ray_origin(point, n), n, triangle);
      sum[side].met += seen.met / static_cast<float>(places);
      sum[side].backs += seen.backs / static_cast<float>(places);
    }
  }
  const bool lit_by_no_surface = scene.environment() || !scene.lights().empty();
  const auto solid = [](const Surroundings& s) { return s.met >= kSolid && s.backs >= kSolid * s.met; };
  const auto open = [&](const Surroundings& s) { return !solid(s) && (lit_by_no_surface || s.met > kSomething); };
  const float behind = sum[1].met;
  if (const OpenSides out{open(sum[0]), open(sum[1]), behind}; out.front || out.back) return out;
  // Lit by lamps too small for the rays, if at all.
  if (const OpenSides out{!solid(sum[0]), !solid(sum[1]), behind}; out.front || out.back) return out;
  return {sum[0].met >= sum[1].met, sum[0].met < sum[1].met};
}

/// Numbers of connected groups of triangles, one a face.
std::vector<std::uint32_t> groups_of(const Geometry& geometry, std::span<const BakeFace> faces) {
  std::vector<std::uint32_t> parent(faces.size());
  for (std::uint32_t i = 0; i < parent.size(); ++i) parent[i] = i;
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const SharedEdge& edge : shared_edges(geometry, faces)) {
    const std::uint32_t a = root(edge.face[0]), b = root(edge.face[1]);
    parent[std::max(a, b)] = std::min(a, b);
  }
  for (std::uint32_t i = 0; i < parent.size(); ++i) parent[i] = root(i);
  return parent;
}

bool is_dark(const Scene& scene, std::uint32_t material) {
  const Material& m = scene.materials()[material];
  return m.kind == MaterialKind::diffuse && is_black(m.reflectance.value) && is_black(m.transmittance.value);
}

std::string plural(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// Some triangles, seen from one side.
struct TriangleSide {
  std::span<const std::uint32_t> triangles;
  bool back = false;
};

/// Random points, as texel_points() makes them: a row for each of `sides`, kPlaces long.
constexpr std::size_t kPlaces = 16;
PointGrid places_on(const Scene& scene, const std::vector<TriangleSide>& sides) {
  PointGrid grid;
  grid.width = kPlaces;
  grid.height = static_cast<int>(sides.size());
  grid.on_surfaces = true;
  for (const TriangleSide& side : sides)
    for (std::size_t i = 0; i < kPlaces; ++i) {
      const std::uint32_t triangle = side.triangles[i * side.triangles.size() / kPlaces];
      const auto number = static_cast<std::uint32_t>(i);
      const Vec2 u{to_unit_float(hash_combine(triangle, 2 * number)),
                   to_unit_float(hash_combine(triangle, 2 * number + 1))};
      const Vec2 at = square_to_triangle(u);
      const SurfacePoint point = surface_point(scene, triangle, at);
      grid.position.push_back(point.position);
      grid.normal.push_back(side.back ? -point.geometric_normal : point.geometric_normal);
      grid.from_behind.push_back(share_from_behind(scene, triangle, at));
    }
  return grid;
}

/// An estimate of the mean TexelIrradiance on each of `sides`, W m^-2.
std::vector<RGB> mean_light(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                            const std::vector<TriangleSide>& sides) {
  std::vector<RGB> out(sides.size());
  if (sides.empty()) return out;
  RenderSettings settings;
  settings.integrator = Integrator::path;
  settings.samples = static_cast<std::uint32_t>(std::clamp<std::size_t>(16384 / sides.size(), 4, 64));
  Job job(scene, tracer, settings, nullptr, 0, std::make_shared<const PointGrid>(places_on(*scene, sides)));
  job.wait();
  const Film film = job.snapshot();
  for (std::size_t i = 0; i < film.pixel_count(); ++i) out[i / kPlaces] += film.radiance(i, false) / float{kPlaces};
  return out;
}

/// For each emission of the scene, whether its triangles are left as they are: they glow evenly, and what they reflect
/// is less than kFaint of that.
std::vector<bool> find_lamps(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer) {
  constexpr float kFaint = 0.1f;
  const Geometry& g = scene->geometry();
  std::vector<std::vector<std::uint32_t>> triangles(scene->emissions().size());
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
    const bool scatters =
        is_bakeable(*scene, g.material[t]) &&
        (!is_black(scene->materials()[g.material[t]].reflectance.value) || is_translucent(*scene, g.material[t]));
    if (g.emission[t] != kNone && scatters) triangles[g.emission[t]].push_back(t);
  }
  std::vector<bool> out(triangles.size(), true);
  std::vector<TriangleSide> sides;
  std::vector<std::size_t> emission;
  for (std::size_t e = 0; e < triangles.size(); ++e) {
    if (triangles[e].empty()) continue;
    out[e] = scene->emissions()[e].radiance.texture == kNone;
    if (!out[e]) continue;
    sides.push_back({triangles[e]});
    emission.push_back(e);
  }
  const std::vector<RGB> light = mean_light(scene, tracer, sides);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const RGB albedo = baked_albedo(*scene, sides[i].triangles[0], {1 / 3.0f, 1 / 3.0f});
    const RGB reflected = light[i] * albedo * kInversePi;
    out[emission[i]] =
        max_component(reflected) < kFaint * max_component(scene->emissions()[emission[i]].radiance.value);
  }
  return out;
}

/// The fronts of all triangles to bake.
/// @param lamps for each emission, whether its triangles are lamps
std::vector<BakeFace> baked_fronts(const Scene& scene, const std::vector<bool>& lamps,
                                   std::vector<std::string>& notes) {
  const Geometry& g = scene.geometry();
  std::vector<BakeFace> out;
  std::map<std::uint32_t, std::size_t> left;
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
    const bool glows = g.emission[t] != kNone;
    if (glows ? lamps[g.emission[t]] : is_dark(scene, g.material[t])) continue;
    if (!is_bakeable(scene, g.material[t])) {
      ++left[g.material[t]];
      continue;
    }
    out.push_back({t, false});
  }
  for (const auto& [material, count] : left)
    notes.push_back(fmt::format("material '{}' ({}) is not baked: its appearance depends on the viewpoint",
                                scene.materials()[material].name, plural(count, "triangle")));
  return out;
}

/// Triangles that are connected, and the sides of them that get texels.
struct Group {
  std::vector<std::uint32_t> triangles;
  OpenSides open;
};

/// Closes the sides of groups that get less than a ten-thousandth of the mean light, such as the inside of a
/// box without a bottom.
void close_dark_sides(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                      std::map<std::uint32_t, Group>& groups) {
  constexpr double kDark = 1e-4;
  std::vector<const Group*> both;
  for (const auto& [number, group] : groups)
    if (group.open.front && group.open.back) both.push_back(&group);
  if (both.empty()) return;
  std::vector<TriangleSide> sides;
  for (const bool back : {true, false})
    for (const Group* group : both) sides.push_back({group->triangles, back});
  std::vector<double> light;
  double sum = 0;
  for (const RGB& irradiance : mean_light(scene, tracer, sides)) {
    light.push_back(luminance(irradiance));
    sum += light.back();
  }
  const double least = kDark * sum / static_cast<double>(light.size());
  std::size_t i = 0;
  for (auto& [number, group] : groups) {
    if (!group.open.front || !group.open.back) continue;
    const bool back = light[i] > least, front = light[i + both.size()] > least;
    group.open.front = front || !back;
    group.open.back = back;
    ++i;
  }
}

/// Replaces fronts by backs, or adds these, where light can only be there.
/// @param roofs gets BakeLayout::roofs
std::vector<BakeFace> with_sides(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                                 std::span<const BakeFace> fronts, std::vector<std::uint8_t>& roofs) {
  constexpr float kCovers = 0.5f;
  const Geometry& g = scene->geometry();
  const auto one_sided = [&](std::uint32_t t) { return scene->materials()[g.material[t]].single_sided; };
  const std::vector<std::uint32_t> number = groups_of(g, fronts);
  std::map<std::uint32_t, Group> groups;
  for (std::size_t i = 0; i < fronts.size(); ++i) groups[number[i]].triangles.push_back(fronts[i].triangle);
  for (auto& [first, group] : groups) group.open = open_sides(*scene, *tracer, group.triangles);
  close_dark_sides(scene, tracer, groups);
  std::vector<BakeFace> out;
  for (std::size_t i = 0; i < fronts.size(); ++i) {
    const std::uint32_t t = fronts[i].triangle;
    const OpenSides& own = groups.at(number[i]).open;
    roofs[t] = own.back && own.behind > kCovers;
    const OpenSides open = one_sided(t) ? OpenSides{} : own;
    if (open.front || g.emission[t] != kNone) out.push_back({t, false});
    if (open.back) out.push_back({t, true});
  }
  return out;
}

}  // namespace

std::string memory_remedy(bool of_probes) {
  return fmt::format("Give a larger --memory, or a {}.",
                     of_probes ? "larger --spacing" : "smaller --atlas or --texels-per-metre");
}

std::uint64_t texel_table_bytes(std::uint64_t points, std::uint64_t memory_bytes, bool of_probes) {
  const std::uint64_t tables = points * kTexelTableBytes;
  if (tables >= memory_bytes)
    throw MemoryError(fmt::format("{:.0f} MB for the places of {} exceed the memory budget of {:.0f} MB",
                                  static_cast<double>(tables) / 1e6, of_probes ? "probes" : "texels",
                                  static_cast<double>(memory_bytes) / 1e6),
                      memory_remedy(of_probes));
  return tables;
}

bool is_bakeable(const Scene& scene, std::uint32_t material) {
  const Material& m = scene.materials()[material];
  const float alpha = std::max(m.roughness_u.value, m.roughness_v.value);
  const bool rough = alpha >= kSpecularAlpha || m.roughness_u.texture != kNone;
  switch (m.kind) {
    case MaterialKind::diffuse:
    case MaterialKind::coated_diffuse:
      return true;
    case MaterialKind::conductor:
    case MaterialKind::coated_conductor:
      return rough;
    case MaterialKind::dielectric:
    case MaterialKind::thin_dielectric:
    case MaterialKind::interface:
    case MaterialKind::measured:
      return false;
    case MaterialKind::metallic_roughness: {
      const bool metal = m.metallic.value > 0.5f && m.metallic.texture == kNone;
      return !(m.transmission.value > 0) && (rough || !metal);
    }
    case MaterialKind::mix:
      return is_bakeable(scene, m.mix_a) && is_bakeable(scene, m.mix_b);
  }
  return false;
}

bool is_inside_solid(const Scene& scene, const Tracer& tracer, Vec3 position) {
  constexpr float kNearlyAll = 1.8f;  // of the two half spaces
  return look_around(scene, tracer, position, {0, 0, 1}, 1).backs +
             look_around(scene, tracer, position, {0, 0, -1}, 2).backs >
         kNearlyAll;
}

std::shared_ptr<const Scene> without_instances(const std::shared_ptr<const Scene>& scene) {
  if (scene->geometry().instances.empty()) return scene;
  SceneEdit edit{scene->emissions(), scene->lights(), scene->environment(), nullptr, {}, ""};
  edit.geometry = std::make_shared<const Geometry>(scene->geometry().expanded());
  return std::make_shared<const Scene>(*scene, std::move(edit));
}

BakeLayout lay_out(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                   const AtlasRequest& request) {
  const Geometry& g = scene->geometry();
  if (!g.instances.empty()) throw Error("the scene to bake has instances", "Bake without_instances() of it.");
  BakeLayout layout;
  layout.roofs.resize(g.triangle_count(), 0);
  const std::vector<BakeFace> fronts = baked_fronts(*scene, find_lamps(scene, tracer), layout.notes);
  layout.faces = with_sides(scene, tracer, fronts, layout.roofs);
  if (layout.faces.empty())
    throw Error("the scene has no surface to bake", "Lamps, glass and mirrors are left as they are.");
  OwnCharts own = own_charts(g, layout.faces);
  layout.charts = std::move(own.charts);
  layout.notes.insert(layout.notes.end(), own.reasons.begin(), own.reasons.end());
  std::vector<BakeFace> rest;
  for (const std::uint32_t f : own.rest) rest.push_back(layout.faces[f]);
  for (Chart& chart : make_charts(g, rest)) {
    for (std::uint32_t& f : chart.faces) f = own.rest[f];
    layout.charts.push_back(std::move(chart));
  }
  layout.atlas = pack(layout.charts, request);
  const auto side = static_cast<std::uint64_t>(layout.atlas.side);
  texel_table_bytes(side * side * static_cast<std::uint64_t>(layout.atlas.count), request.memory_bytes);
  if (layout.atlas.shrunk > 0)
    layout.notes.push_back(fmt::format("{} larger than an atlas, with fewer texels per metre: give a larger --atlas",
                                       plural(layout.atlas.shrunk, "chart")));
  layout.texels = map_texels(layout.charts, layout.atlas);
  return layout;
}

PointGrid texel_points(const Scene& scene, const Tracer& tracer, const BakeLayout& layout) {
  constexpr float kInside = 0.5f;  ///< share of rays that meet backs where a point is inside of something
  const TexelMap& map = layout.texels;
  PointGrid grid;
  grid.width = map.width;
  grid.height = map.height;
  grid.position.assign(map.face.size(), Vec3{});
  grid.normal.assign(map.face.size(), Vec3{});
  grid.surface = map.chart;
  grid.on_surfaces = grid.learns = true;
  const auto& materials = scene.materials();
  for (std::uint32_t m = 0; m < materials.size() && grid.from_behind.empty(); ++m)
    if (is_translucent(scene, m)) grid.from_behind.resize(map.face.size());
  std::vector<std::uint8_t> inside(map.face.size(), 0);
  parallel_for(0, map.face.size(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (map.face[i] == kNone) continue;
      const BakeFace face = layout.faces[map.face[i]];
      SurfacePoint point = surface_point(scene, face.triangle, map.barycentric[i]);
      if (!(length_squared(point.geometric_normal) > 0)) continue;
      const Vec3 side = face.back ? -point.geometric_normal : point.geometric_normal;
      grid.position[i] = point.position;
      grid.normal[i] = face.back ? -point.frame.n : point.frame.n;
      if (is_translucent(scene, point.material)) grid.from_behind[i] = share_from_behind(scene, layout, i);
      const auto number = static_cast<std::uint32_t>(i);
      const Vec3 origin = ray_origin(point, side);
      // Nearly all points are in the open, which four rays tell.
      inside[i] = look_around(scene, tracer, origin, side, number, 4, layout.roofs).backs > 0 &&
                  look_around(scene, tracer, origin, side, number, kRays, layout.roofs).backs > kInside;
    }
  });
  // Where most of a chart meets backs, the backs are what its room shows.
  std::vector<std::size_t> points(layout.charts.size(), 0), hidden(layout.charts.size(), 0);
  for (std::size_t i = 0; i < inside.size(); ++i)
    if (grid.has(i)) {
      ++points[map.chart[i]];
      hidden[map.chart[i]] += inside[i];
    }
  for (std::size_t i = 0; i < inside.size(); ++i)
    if (inside[i] && 2 * hidden[map.chart[i]] < points[map.chart[i]]) grid.normal[i] = Vec3{};
  return grid;
}

}  // namespace glowworm
