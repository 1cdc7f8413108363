// Nodes of the texture graphs that importers build.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "scene/texture.h"

namespace glowworm {

/// Adds a texture node, one that shows an image, or one of the product of two nodes. Returns its index.
std::uint32_t add_node(std::vector<TextureNode>& textures, TextureNode node);
std::uint32_t add_image_node(std::vector<TextureNode>& textures, std::shared_ptr<const TextureImage> image);
std::uint32_t add_product_node(std::vector<TextureNode>& textures, std::uint32_t a, std::uint32_t b);

}  // namespace glowworm
