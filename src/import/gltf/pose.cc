#include "import/gltf/pose.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "core/error.h"
#include "import/gltf/accessor.h"
#include "import/gltf/document.h"

namespace glowworm {

namespace {

TransformDouble matrix_of(const auto& m, std::size_t first) {
  const auto column = [&](std::size_t i) {
    return Vec3d{double{m[first + 4 * i]}, double{m[first + 4 * i + 1]}, double{m[first + 4 * i + 2]}};
  };
  return {column(0), column(1), column(2), column(3)};
}

}  // namespace

Vec3d vector_of(const std::vector<double>& v, Vec3d otherwise) {
  return v.size() == 3 ? Vec3d{v[0], v[1], v[2]} : otherwise;
}

TransformDouble gltf_rotation_and_scale(const double q[4], Vec3d scale) {
  const double n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  const double s = n > 0 ? 2 / n : 0;
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  return {Vec3d{1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)} * scale.x,
          Vec3d{s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x)} * scale.y,
          Vec3d{s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y)} * scale.z,
          {0, 0, 0}};
}

GltfPose::GltfPose(const GltfDocument& document, const Moment& moment) : document_(document) {
  const tinygltf::Model& model = *document.model;
  GltfNodeValues values;
  for (const tinygltf::Node& node : model.nodes) {
    values.translation.push_back(node.translation);
    values.rotation.push_back(node.rotation);
    values.scale.push_back(node.scale);
    const std::vector<double>& weights = node.weights.empty() && node.mesh >= 0
                                             ? model.meshes[static_cast<std::size_t>(node.mesh)].weights
                                             : node.weights;
    values.weights.emplace_back(weights.begin(), weights.end());
  }
  for (const tinygltf::Camera& c : model.cameras)
    values.lenses.push_back({c.perspective.yfov, c.perspective.aspectRatio, c.orthographic.xmag, c.orthographic.ymag});
  animate(document, moment.animation, moment.seconds, values);
  weights_ = std::move(values.weights);
  lenses_ = std::move(values.lenses);
  const double identity[4] = {0, 0, 0, 1};
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    if (model.nodes[i].matrix.size() == 16) {
      local_.push_back(matrix_of(model.nodes[i].matrix, 0));
      continue;
    }
    TransformDouble t = gltf_rotation_and_scale(values.rotation[i].size() == 4 ? values.rotation[i].data() : identity,
                                                vector_of(values.scale[i], {1, 1, 1}));
    t.translation = vector_of(values.translation[i], {0, 0, 0});
    local_.push_back(t);
  }
  to_world_.resize(local_.size());
}

GltfDeformation GltfPose::deformation(int index, Vec3 origin) const {
  const tinygltf::Node& node = document_.model->nodes[static_cast<std::size_t>(index)];
  GltfDeformation out;
  out.weights = weights_[static_cast<std::size_t>(index)];
  if (node.skin < 0) return out;
  const tinygltf::Skin& skin = document_.model->skins[static_cast<std::size_t>(node.skin)];
  std::vector<float> inverses;
  if (skin.inverseBindMatrices >= 0) inverses = read_floats(document_, skin.inverseBindMatrices, 16);
  if (!inverses.empty() && inverses.size() < 16 * skin.joints.size()) {
    throw Error({document_.path},
                fmt::format("skins[{}] has {} joints, but only {} matrices", node.skin, skin.joints.size(),
                            inverses.size() / 16),
                "The file is damaged or invalid: export it again.");
  }
  for (std::size_t i = 0; i < skin.joints.size(); ++i) {
    const TransformDouble inverse = inverses.empty() ? TransformDouble{} : matrix_of(inverses, 16 * i);
    out.joints.push_back((to_world(skin.joints[i]) * inverse).relative_to(origin));
  }
  return out;
}

}  // namespace glowworm
