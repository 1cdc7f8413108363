// Where the nodes of a glTF file stand at its first moment.
#pragma once
#include <vector>

#include "core/transform.h"
#include "import/gltf/mesh.h"

namespace glowworm {

struct GltfDocument;

/// The nodes of a file at time 0 of its first animation; as the file places them where it has none.
class GltfPose {
 public:
  /// Throws Error where an animation or a skin has too few numbers.
  explicit GltfPose(const GltfDocument& document);

  /// A node's transform relative to its parent.
  const Transform& local(int node) const { return local_[static_cast<std::size_t>(node)]; }
  /// Says where a node stands in the world.
  void place(int node, const Transform& to_world) { to_world_[static_cast<std::size_t>(node)] = to_world; }
  const Transform& to_world(int node) const { return to_world_[static_cast<std::size_t>(node)]; }
  /// What a node with a mesh does to its vertices, once all nodes are placed.
  GltfDeformation deformation(int node) const;

 private:
  void animate(std::vector<std::vector<double>>& translations, std::vector<std::vector<double>>& rotations,
               std::vector<std::vector<double>>& scales);

  const GltfDocument& document_;
  std::vector<Transform> local_, to_world_;
  std::vector<std::vector<float>> weights_;  ///< of morph targets, by node
};

/// A rotation by a quaternion (x, y, z, w), which need not be quite unit, after a scale.
Transform gltf_rotation_and_scale(const double q[4], Vec3 scale);

}  // namespace glowworm
