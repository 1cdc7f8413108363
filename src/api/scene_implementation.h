// Contents of a public scene.
#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "glowworm/scene.h"
#include "import/gltf/parts.h"
#include "scene/scene.h"
#include "trace/tracer.h"

namespace glowworm::api {

/// The vector as the rooms have it, in its own unit.
inline glowworm::Vec3 inner(Vec3 v) { return {v.x, v.y, v.z}; }
/// The camera as the rooms have it, in the user's coordinates. Throws Error for one that sees nothing.
glowworm::Camera inner(const Camera& camera);

struct Scene::Implementation {
  explicit Implementation(SceneDescription description, std::shared_ptr<const GltfParts> parts = nullptr,
                          std::vector<std::string> outside = {})
      : Implementation(std::make_shared<const glowworm::Scene>(std::move(description)), std::move(parts),
                       std::move(outside)) {}
  Implementation(std::shared_ptr<const glowworm::Scene> whole, std::shared_ptr<const GltfParts> parts,
                 std::vector<std::string> outside)
      : gltf_parts(std::move(parts)),
        outside_files(std::move(outside)),
        scene(std::move(whole)),
        traced(scene),
        tracer(std::make_shared<const glowworm::Tracer>(*traced)),
        arrays(std::make_shared<Arrays>()) {}
  /// The scene with more cameras, which the tracer does not know of.
  Implementation(const Implementation& other, SceneEdit edit)
      : gltf_parts(other.gltf_parts),
        outside_files(other.outside_files),
        scene(std::make_shared<const glowworm::Scene>(*other.scene, std::move(edit))),
        traced(other.traced),
        tracer(other.tracer),
        arrays(other.arrays) {}

  std::shared_ptr<const GltfParts> gltf_parts;           ///< of a glTF file; null for others
  std::vector<std::string> outside_files;                ///< read from outside of the scene file's folder
  std::shared_ptr<const glowworm::Scene> scene, traced;  ///< `traced` is the tracer's
  std::shared_ptr<const glowworm::Tracer> tracer;

  /// All triangles, without instances, in the user's coordinates.
  const Geometry& geometry() const {
    const Geometry& own = traced->geometry();
    if (own.instances.empty() && scene->origin() == glowworm::Vec3{0, 0, 0}) return own;
    std::call_once(arrays->made, [&] {
      arrays->geometry = own.expanded();
      for (glowworm::Vec3& p : arrays->geometry.positions) p = narrow(scene->outside(p));
    });
    return arrays->geometry;
  }

 private:
  struct Arrays {
    std::once_flag made;
    Geometry geometry;
  };
  std::shared_ptr<Arrays> arrays;
};

}  // namespace glowworm::api
