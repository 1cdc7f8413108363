#include "bake/probes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bake/layout.h"
#include "core/error.h"
#include "core/json_text.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr int kAxes = 6;

Vec3 probe_direction(int i) {
  Vec3 out;
  if (i < kAxes) {
    out[i / 2] = i % 2 == 0 ? 1.0f : -1.0f;
    return out;
  }
  for (int axis = 0; axis < 3; ++axis) out[axis] = ((i - kAxes) >> axis) % 2 == 0 ? 1.0f : -1.0f;
  return normalize(out);
}

std::array<float, 9> harmonics(Vec3 n) {
  return {0.282095f,
          0.488603f * n.y,
          0.488603f * n.z,
          0.488603f * n.x,
          1.092548f * n.x * n.y,
          1.092548f * n.y * n.z,
          0.315392f * (3 * n.z * n.z - 1),
          1.092548f * n.x * n.z,
          0.546274f * (n.x * n.x - n.y * n.y)};
}

std::vector<ProbeLight> fit_probes(const ProbeGrid& probes, const std::vector<RGB>& irradiance) {
  std::vector<ProbeLight> out;
  for (std::size_t p = 0; p < probes.position.size(); ++p) {
    std::array<RGB, kProbeDirections> measured;
    std::copy_n(irradiance.begin() + static_cast<std::ptrdiff_t>(p * kProbeDirections), kProbeDirections,
                measured.begin());
    out.push_back(fit_probe(measured));
  }
  return out;
}

/// The grid without its light.
json describe(const ProbeGrid& probes, const std::string& command_line) {
  return {{"command", command_line},
          {"unit", "irradiance, W m^-2, linear RGB (Rec. 709)"},
          {"basis", "real orthonormal spherical harmonics of the normal: 1, y, z, x, xy, yz, 3z^2-1, xz, x^2-y^2"},
          {"origin", {probes.origin.x, probes.origin.y, probes.origin.z}},
          {"spacing", probes.spacing},
          {"counts", probes.counts},
          {"order", "x runs fastest, then y, then z; null: inside of a solid object"}};
}

}  // namespace

ProbeGrid make_probes(const Scene& scene, const Tracer& tracer, float spacing) {
  const Box3 bounds = scene.bounds();
  ProbeGrid out;
  out.spacing = spacing;
  Vec3 first;
  double count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = bounds.max[axis] - bounds.min[axis];
    const double along = std::max(1.0, std::floor(static_cast<double>(extent) / spacing));
    count *= along;
    if (count > kMaxProbes)
      throw Error(fmt::format("probes every {:g} m are more than {:g}", spacing, kMaxProbes),
                  "Give a larger --spacing.");
    out.counts[static_cast<std::size_t>(axis)] = static_cast<int>(along);
    first[axis] = bounds.min[axis] + 0.5f * (extent - spacing * static_cast<float>(along - 1));
  }
  for (int z = 0; z < out.counts[2]; ++z)
    for (int y = 0; y < out.counts[1]; ++y)
      for (int x = 0; x < out.counts[0]; ++x)
        out.position.push_back(first +
                               Vec3{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)} * spacing);
  out.origin = scene.outside(first);
  out.is_inside.resize(out.position.size());
  parallel_for_each(out.position.size(), 64,
                    [&](std::size_t i) { out.is_inside[i] = is_inside_solid(scene, tracer, out.position[i]); });
  return out;
}

PointGrid probe_points(const ProbeGrid& probes) {
  PointGrid grid;
  grid.width = kProbeDirections;
  grid.height = static_cast<int>(probes.position.size());
  for (std::size_t p = 0; p < probes.position.size(); ++p)
    for (int i = 0; i < kProbeDirections; ++i) {
      grid.position.push_back(probes.position[p]);
      grid.normal.push_back(probes.is_inside[p] ? Vec3{} : probe_direction(i));
    }
  return grid;
}

ProbeLight fit_probe(const std::array<RGB, kProbeDirections>& irradiance) {
  // The directions have the symmetries of a cube, so that the normal equations are diagonal.
  ProbeLight out;
  std::array<float, 9> squares{};
  for (int i = 0; i < kProbeDirections; ++i) {
    const std::array<float, 9> y = harmonics(probe_direction(i));
    for (std::size_t k = 0; k < y.size(); ++k) {
      out[k] += irradiance[static_cast<std::size_t>(i)] * y[k];
      squares[k] += y[k] * y[k];
    }
  }
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = out[k] / squares[k];
  return out;
}

RGB evaluate(const ProbeLight& light, Vec3 normal) {
  const std::array<float, 9> y = harmonics(normal);
  RGB out;
  for (std::size_t k = 0; k < y.size(); ++k) out += light[k] * y[k];
  return out;
}

Image probes_image(const ProbeGrid& probes, const std::vector<RGB>& irradiance, const std::string& command_line) {
  Image out(probes.counts[0], probes.counts[1] * probes.counts[2]);
  std::vector<RGB> layer(probes.position.size());
  const std::vector<ProbeLight> lights = fit_probes(probes, irradiance);
  for (std::size_t k = 0; k < ProbeLight().size(); ++k) {
    for (std::size_t p = 0; p < layer.size(); ++p) layer[p] = probes.is_inside[p] ? RGB() : lights[p][k];
    out.add_rgb(fmt::format("Y{}", k), layer);
  }
  const json grid = describe(probes, command_line);
  for (const char* name : {"command", "unit", "basis"}) out.metadata[name] = grid[name].get<std::string>();
  for (const char* name : {"origin", "spacing", "counts"}) out.metadata[name] = grid[name].dump();
  return out;
}

std::string probes_json(const ProbeGrid& probes, const std::vector<RGB>& irradiance, const std::string& command_line) {
  json out = describe(probes, command_line);
  json& list = out["probes"] = json::array();
  const std::vector<ProbeLight> lights = fit_probes(probes, irradiance);
  for (std::size_t p = 0; p < lights.size(); ++p) {
    json coefficients = json::array();
    for (const RGB& c : lights[p]) coefficients.push_back({c.r, c.g, c.b});
    list.push_back(probes.is_inside[p] ? json() : coefficients);
  }
  return json_text(out) + "\n";
}

}  // namespace glowworm
