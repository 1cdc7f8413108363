// The pose of a glTF file's nodes at a moment.
#pragma once
#include <vector>

#include "core/transform_double.h"
#include "import/gltf/animation.h"
#include "import/gltf/mesh.h"
#include "import/import.h"

namespace glowworm {

struct GltfDocument;

/// The vector of three numbers; `otherwise` if there are not three.
Vec3d vector_of(const std::vector<double>& v, Vec3d otherwise);

/// The nodes of a file at a moment of an animation, or their static transforms if there is none.
class GltfPose {
 public:
  /// Throws Error if an animation or a skin has too few numbers, and for an unknown animation.
  GltfPose(const GltfDocument& document, const Moment& moment);

  /// A node's transform relative to its parent.
  const TransformDouble& local(int node) const { return local_[static_cast<std::size_t>(node)]; }
  /// Sets a node's transform to the world.
  void place(int node, const TransformDouble& to_world) { to_world_[static_cast<std::size_t>(node)] = to_world; }
  const TransformDouble& to_world(int node) const { return to_world_[static_cast<std::size_t>(node)]; }
  /// Weights of morph targets of a node.
  const std::vector<float>& weights(int node) const { return weights_[static_cast<std::size_t>(node)]; }
  const GltfLens& lens(int camera) const { return lenses_[static_cast<std::size_t>(camera)]; }
  /// The deformation of a mesh by a node, to places relative to `origin`. All nodes must be placed.
  GltfDeformation deformation(int node, Vec3 origin) const;

 private:
  const GltfDocument& document_;
  std::vector<TransformDouble> local_, to_world_;
  std::vector<std::vector<float>> weights_;  ///< of morph targets, by node
  std::vector<GltfLens> lenses_;             // by camera
};

/// A scale, followed by a rotation by a quaternion (x, y, z, w), which need not be exactly unit.
TransformDouble gltf_rotation_and_scale(const double q[4], Vec3d scale);

}  // namespace glowworm
