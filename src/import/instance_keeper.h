// Decides which meshes of a file are kept as instances.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "core/coordinate_origin.h"
#include "core/memory_budget.h"
#include "scene/geometry.h"

namespace glowworm {

/// A mesh that a file places more than once.
struct SharedMesh {
  Geometry geometry;     ///< with materials, and without emission
  Vec3d pivot{0, 0, 0};  ///< the place in the mesh's space that its positions are relative to
};

/// Keeps the places of a mesh as instances, from the second on, where that saves memory. The first place is a copy of
/// the mesh, as of a mesh that is placed once: a reader need not know how often it will be.
class InstanceKeeper {
 public:
  /// @param scene, origin, triangles of the reader; they must live as long as this
  InstanceKeeper(Geometry& scene, CoordinateOrigin& origin, Reservation& triangles)
      : scene_(scene), origin_(origin), triangles_(triangles) {}

  /// Adds an instance of a mesh, and returns its index; kNone if the caller has to add the triangles themselves. Throws
  /// MemoryError if the budget is too small.
  /// @param key identifies the mesh
  /// @param object name of the instance
  /// @param make the mesh; called once, with the second place; a mesh without triangles is not kept
  std::uint32_t keep(const void* key, const TransformDouble& to_world, const std::string& object,
                     const std::function<SharedMesh()>& make);

 private:
  struct Use {
    TransformDouble first;
    bool made = false, worthwhile = false;
    Vec3d pivot{0, 0, 0};
    Box3 bounds;
    std::uint32_t mesh[2] = {kNone, kNone};  // as it is and mirrored, in Geometry::meshes
  };
  void make_mesh(Use& use, SharedMesh mesh);
  std::uint32_t mirrored(Use& use);

  Geometry& scene_;
  CoordinateOrigin& origin_;
  Reservation& triangles_;
  std::map<const void*, Use> uses_;
};

/// Memory of all places of a mesh if those from the second on are instances where that saves memory, bytes.
double shared_bytes(const Geometry& mesh, double places);

}  // namespace glowworm
