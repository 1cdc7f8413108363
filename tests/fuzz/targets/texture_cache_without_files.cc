// The textures of an import without an image decoder, so that coverage counters are only about the scene files.
#include "import/texture_cache.h"

namespace glowworm {

namespace {

class GreyImage final : public TextureImage {
  RGB color(Vec2) const override { return RGB(0.5f); }
  float alpha(Vec2) const override { return 0.5f; }
  bool has_alpha() const override { return true; }
  int width() const override { return 2; }
  int height() const override { return 2; }
};

}  // namespace

struct TextureCache::State {};

TextureCache::TextureCache(const ImportOptions&, NoteCounter&) {}
TextureCache::~TextureCache() = default;

std::shared_ptr<const TextureImage> TextureCache::load_file(const std::string&, const TextureOptions&, StandIn) {
  return std::make_shared<GreyImage>();
}

std::shared_ptr<const TextureImage> TextureCache::load_needed_file(const std::string&, const TextureOptions&) {
  return std::make_shared<GreyImage>();
}

std::shared_ptr<const TextureImage> TextureCache::load_memory(const std::string&, std::span<const std::uint8_t> bytes,
                                                              const TextureOptions&, StandIn) {
  // Every byte is read, as a decoder may.
  for (const std::uint8_t byte : bytes) static_cast<void>(static_cast<const volatile std::uint8_t&>(byte));
  return std::make_shared<GreyImage>();
}

std::shared_ptr<const TextureImage> TextureCache::missing(const std::string&, const std::string&, StandIn) {
  return std::make_shared<GreyImage>();
}

std::string find_texture_file(const std::string& folder, const std::string& name) { return folder + "/" + name; }

}  // namespace glowworm
