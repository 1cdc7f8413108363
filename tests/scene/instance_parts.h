// Building blocks for tests of instances.
#pragma once
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/random.h"
#include "core/warp.h"
#include "scene/scene.h"

namespace glowworm {

/// Adds a mesh, and returns its number.
inline std::uint32_t add_shared_mesh(SceneDescription& d, Geometry mesh) {
  d.geometry.meshes.push_back(std::make_shared<const Geometry>(std::move(mesh)));
  return static_cast<std::uint32_t>(d.geometry.meshes.size() - 1);
}

/// Places meshes. A map that mirrors needs a mesh that is wound the other way.
inline void add_places(SceneDescription& d, std::uint32_t mesh, const std::vector<Transform>& places) {
  for (const Transform& place : places) d.geometry.instances.push_back({place, mesh, 0, 0});
  d.geometry.number_instances();
}

/// The mesh seen in a mirror: its triangles are wound the other way.
inline Geometry wound_back(Geometry mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

/// Without instances.
inline SceneDescription expanded(SceneDescription d) {
  d.geometry = d.geometry.expanded();
  return d;
}

/// A map that turns, stretches, shears and moves. @param mirrors whether its determinant is negative
inline Transform random_place(std::uint32_t index, bool mirrors, float size = 1, float reach = 1) {
  Sampler sampler(SamplerKind::independent, 11, 5, index);
  const auto vector = [&] { return square_to_sphere(sampler.next2()); };
  Transform m;
  do {
    m = {vector() * size, vector() * size, vector() * (2 * size), vector() * reach};
  } while (std::abs(m.determinant()) < 0.4f * size * size * size);
  if ((m.determinant() < 0) != mirrors) m.x = -m.x;
  return m;
}

}  // namespace glowworm
