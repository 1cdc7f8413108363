#include "import/instance_keeper.h"

#include <algorithm>
#include <utility>

#include "import/mesh_tools.h"
#include "scene/scene_checks.h"

namespace glowworm {

namespace {

/// Memory of an instance, bytes: its entry in the scene, its name, and its part of Embree's structure.
constexpr std::uint64_t kInstanceBytes = sizeof(Instance) + sizeof(ObjectStart) + 110;

/// Rays take longer to meet instances than copies, so an instance must save most of a copy's memory.
bool saves_memory(const Geometry& mesh) {
  constexpr std::uint64_t kLeastSaving = 16;
  return scene_bytes(mesh) >= kLeastSaving * kInstanceBytes;
}

bool are_same(const TransformDouble& a, const TransformDouble& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.translation == b.translation;
}

}  // namespace

std::uint32_t InstanceKeeper::keep(const void* key, const TransformDouble& to_world, const std::string& object,
                                   const std::function<SharedMesh()>& make) {
  const auto [entry, is_first] = uses_.try_emplace(key);
  Use& use = entry->second;
  if (is_first) {
    use.first = to_world;
    return kNone;
  }
  if (!use.made) make_mesh(use, make());
  // A copy in the place of the first is found by repeated_triangles().
  if (!use.worthwhile || are_same(to_world, use.first)) return kNone;
  TransformDouble placed = to_world;
  placed.translation = to_world.point(use.pivot);
  const Transform map = placed.relative_to(origin_.origin());
  if (!is_placeable(map)) return kNone;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d place = placed.point({corner & 1 ? use.bounds.max.x : use.bounds.min.x,
                                      corner & 2 ? use.bounds.max.y : use.bounds.min.y,
                                      corner & 4 ? use.bounds.max.z : use.bounds.min.z});
    if (!is_within_bounds(narrow(place))) return kNone;
    origin_.cover(place);
  }
  triangles_.grow(kInstanceBytes);
  const auto number = static_cast<std::uint32_t>(scene_.instances.size());
  if (scene_.instance_objects.empty() || scene_.instance_objects.back().name != object)
    scene_.instance_objects.push_back({number, object});
  const std::uint32_t mesh = map.determinant() < 0 ? mirrored(use) : use.mesh[0];
  scene_.instances.push_back({map, mesh, 0, 0});
  return number;
}

void InstanceKeeper::make_mesh(Use& use, SharedMesh mesh) {
  use.made = true;
  use.worthwhile = !mesh.geometry.triangles.empty() && saves_memory(mesh.geometry);
  if (!use.worthwhile) return;
  triangles_.grow(scene_bytes(mesh.geometry));
  use.pivot = mesh.pivot;
  use.bounds = mesh.geometry.bounds();
  use.mesh[0] = static_cast<std::uint32_t>(scene_.meshes.size());
  scene_.meshes.push_back(std::make_shared<const Geometry>(std::move(mesh.geometry)));
}

/// The mesh with its triangles wound the other way, so that their outside stays outside where it is mirrored.
std::uint32_t InstanceKeeper::mirrored(Use& use) {
  if (use.mesh[1] != kNone) return use.mesh[1];
  Geometry mesh = *scene_.meshes[use.mesh[0]];
  triangles_.grow(scene_bytes(mesh));
  reverse_winding(mesh);
  use.mesh[1] = static_cast<std::uint32_t>(scene_.meshes.size());
  scene_.meshes.push_back(std::make_shared<const Geometry>(std::move(mesh)));
  return use.mesh[1];
}

double shared_bytes(const Geometry& mesh, double places) {
  const auto bytes = static_cast<double>(scene_bytes(mesh));
  if (!saves_memory(mesh)) return places * bytes;
  return std::min(places, 3.0) * bytes + places * static_cast<double>(kInstanceBytes);
}

}  // namespace glowworm
