#include "import/texture_nodes.h"

#include <utility>

namespace glowworm {

std::uint32_t add_node(std::vector<TextureNode>& textures, TextureNode node) {
  textures.push_back(std::move(node));
  return static_cast<std::uint32_t>(textures.size() - 1);
}

std::uint32_t add_image_node(std::vector<TextureNode>& textures, std::shared_ptr<const TextureImage> image) {
  TextureNode node;
  node.kind = TextureKind::image;
  node.image = std::move(image);
  return add_node(textures, std::move(node));
}

std::uint32_t add_product_node(std::vector<TextureNode>& textures, std::uint32_t a, std::uint32_t b) {
  TextureNode node;
  node.kind = TextureKind::scale;
  node.child_a = a;
  node.child_b = b;
  return add_node(textures, std::move(node));
}

}  // namespace glowworm
