// Scenes with participating media.
#pragma once
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "gather/point_pass.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {

inline Medium medium_of(float sigma_t, float albedo, float g = 0) {
  Medium medium;
  medium.sigma_s = RGB(sigma_t * albedo);
  medium.sigma_a = RGB(sigma_t * (1 - albedo));
  medium.g = g;
  return medium;
}

/// The same medium with a grid of even density.
inline Medium as_grid(Medium medium, Box3 bounds) {
  medium.bounds = bounds;
  MediumGridValues values;
  values.size = {3, 3, 3};
  values.density.assign(27, 1.0f);
  // Densities fall off in the outer half of the border's cells: those are put outside.
  medium.grid = std::make_shared<const MediumGrid>(std::move(values));
  const Vec3 half = bounds.diagonal() * 0.25f;
  medium.bounds = Box3{bounds.min - half, bounds.max + half};
  return medium;
}

/// Adds a material of that albedo, 0 for black.
inline std::uint32_t add_material(SceneDescription& d, float albedo) {
  d.materials.emplace_back().reflectance.value = RGB(albedo);
  return static_cast<std::uint32_t>(d.materials.size() - 1);
}

/// Adds the six sides of a box, whose fronts face outwards.
inline void add_box(SceneDescription& d, Vec3 low, Vec3 high, std::uint32_t material, std::uint32_t emission = kNone) {
  const Vec3 s = high - low;
  const Vec3 x{s.x, 0, 0}, y{0, s.y, 0}, z{0, 0, s.z};
  add_quad(d, low, y, x, material, emission);
  add_quad(d, low, x, z, material, emission);
  add_quad(d, low, z, y, material, emission);
  add_quad(d, high, -x, -y, material, emission);
  add_quad(d, high, -z, -x, material, emission);
  add_quad(d, high, -y, -z, material, emission);
}

/// Adds an interface around a box of a medium in vacuum.
inline void add_medium_box(SceneDescription& d, Vec3 low, Vec3 high, Medium medium) {
  Material interface;
  interface.kind = MaterialKind::interface;
  interface.inside = static_cast<std::uint32_t>(d.media.size());
  interface.outside = kNone;
  d.media.push_back(std::move(medium));
  d.materials.push_back(interface);
  add_box(d, low, high, static_cast<std::uint32_t>(d.materials.size() - 1));
}

/// A fog with a lamp over a floor, as a homogeneous medium and as a grid.
inline SceneDescription foggy_floor(bool grid) {
  SceneDescription d;
  const std::uint32_t grey = add_material(d, 0.5f), black = add_material(d, 0);
  add_quad(d, {-2, -2, -1}, {4, 0, 0}, {0, 4, 0}, grey);
  add_quad(d, {-0.5f, -0.5f, 1}, {0, 1, 0}, {1, 0, 0}, black, add_emission(d, RGB(5.0f)));
  Medium fog = medium_of(0.8f, 0.9f, 0.3f);
  fog.sigma_a.r *= 2;
  if (grid) fog = as_grid(fog, Box3{{-2, -2, -1}, {2, 2, 1}});
  add_medium_box(d, {-2, -2, -0.9f}, {2, 2, 0.9f}, fog);
  d.cameras.push_back(look_at({0, -5, 0.5f}, {0, 0, 0}, {0, 0, 1}, 45));
  return d;
}

/// Irradiance at points that face the same way.
inline std::vector<double> irradiance(const Stage& stage, const RenderSettings& settings, std::vector<Vec3> positions,
                                      std::vector<Vec3> normals) {
  PointGrid grid;
  grid.width = static_cast<int>(positions.size());
  grid.height = 1;
  grid.position = std::move(positions);
  grid.normal = std::move(normals);
  Job job(stage.scene, stage.tracer, settings, nullptr, 0, std::make_shared<const PointGrid>(grid));
  job.wait();
  std::vector<double> out;
  for (const RGB& pixel : pixels(job.snapshot())) out.push_back(luminance(pixel));
  return out;
}

/// Irradiance times area over the walls of the box from (-1, -1, -1) to (1, 1, 1), by sensors just before them, which
/// are closer and stand for less area towards the edges: with even ones, the sum would be up to 0.7% too large.
inline double power_on_walls(const Stage& stage, const RenderSettings& settings) {
  std::vector<Vec3> positions, normals;
  constexpr int kSide = 12;
  // The midpoint rule in x, where u = x (3 - x^2) / 2.
  const auto middle = [](int i) { return (static_cast<float>(i) + 0.5f) * 2 / kSide - 1; };
  const auto place = [&](int i) { return middle(i) * (3 - middle(i) * middle(i)) / 2; };
  const auto length = [&](int i) { return double{3 * (1 - middle(i) * middle(i))} / kSide; };
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f})
      for (int i = 0; i < kSide * kSide; ++i) {
        const float u = place(i % kSide), v = place(i / kSide), w = side * 0.999f;
        positions.push_back(axis == 0 ? Vec3{w, u, v} : axis == 1 ? Vec3{u, w, v} : Vec3{u, v, w});
        normals.push_back(axis == 0 ? Vec3{-side, 0, 0} : axis == 1 ? Vec3{0, -side, 0} : Vec3{0, 0, -side});
      }
  const std::vector<double> found = irradiance(stage, settings, positions, normals);
  double sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const int at = static_cast<int>(i) % (kSide * kSide);
    sum += found[i] * length(at % kSide) * length(at / kSide);
  }
  return sum;
}

}  // namespace glowworm
