#include <OpenImageIO/imagecache.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <set>

#include "core/log.h"
#include "image/texel_decoder.h"
#include "image/texture_file.h"

namespace glowworm {

namespace {

constexpr std::uint64_t kMegabyte = 1u << 20;
// A cache smaller than a few tiles a thread does nothing but read.
constexpr std::uint64_t kSmallestCache = 16 * kMegabyte;

std::shared_ptr<OIIO::ImageCache> make_cache(std::uint64_t bytes) {
  configure_openimageio();
  std::shared_ptr<OIIO::ImageCache> cache(OIIO::ImageCache::create(false),
                                          [](OIIO::ImageCache* c) { OIIO::ImageCache::destroy(c, true); });
  cache->attribute("max_memory_MB", static_cast<float>(std::max(bytes, kSmallestCache)) / kMegabyte);
  cache->attribute("autotile", 64);
  cache->attribute("unassociatedalpha", 1);
  cache->attribute("max_open_files", 100);
  return cache;
}

OIIO::TypeDesc type_desc(SampleType type) {
  switch (type) {
    case SampleType::uint8:
      return OIIO::TypeDesc::UINT8;
    case SampleType::uint16:
      return OIIO::TypeDesc::UINT16;
    case SampleType::half:
      return OIIO::TypeDesc::HALF;
    case SampleType::single:
      break;
  }
  return OIIO::TypeDesc::FLOAT;
}

// A texture whose texels come tile by tile out of an image cache.
class CachedTexture final : public TextureFile {
 public:
  CachedTexture(const std::string& path, const ImageFileHeader& header, std::shared_ptr<OIIO::ImageCache> cache,
                const TextureOptions& options)
      : TextureFile(header.width, header.height, header.alpha_channel >= 0, options),
        path_(path),
        header_(header),
        decoder_(header.type, resolve_encoding(options, header.transfer)),
        channels_(std::max(header.channels >= 3 ? 3 : 1, header.alpha_channel + 1)),
        cache_(std::move(cache)),
        handle_(cache_->get_image_handle(OIIO::ustring(path))) {}

  std::uint64_t memory_bytes() const override { return 0; }

  // Whether a look-up's texel fits where fetch_one puts it.
  static bool can_hold(const ImageFileHeader& header) { return std::max(3, header.alpha_channel + 1) <= kMostChannels; }

 protected:
  void fetch(const int x[2], const int y[2], Texel out[4]) const override {
    for (int i = 0; i < 4; ++i) out[i] = fetch_one(x[i % 2], y[i / 2]);
  }

 private:
  static constexpr int kMostChannels = 64;

  Texel fetch_one(int x, int y) const {
    alignas(8) std::byte samples[kMostChannels * sizeof(float)] = {};
    // Once a tile has failed, the cache hands out what it never filled.
    if (lost_.load(std::memory_order_relaxed) || !cache_->get_pixels(handle_, nullptr, 0, 0, x, x + 1, y, y + 1, 0, 1,
                                                                     0, channels_, type_desc(header_.type), samples)) {
      if (!lost_.exchange(true)) {
        const std::string report = cache_->geterror();
        warn(fmt::format("{}: no more texels can be read and the texture is magenta ({})", path_,
                         report.substr(0, report.find('\n'))));
      }
      return {{1, 0, 1}, 1};
    }
    Texel texel;
    texel.color = header_.channels >= 3
                      ? RGB{decoder_.color(samples, 0), decoder_.color(samples, 1), decoder_.color(samples, 2)}
                      : RGB(decoder_.color(samples, 0));
    if (has_alpha()) texel.alpha = decoder_.alpha(samples, static_cast<std::size_t>(header_.alpha_channel));
    return texel;
  }

  std::string path_;
  ImageFileHeader header_;
  TexelDecoder decoder_;
  int channels_;
  std::shared_ptr<OIIO::ImageCache> cache_;
  OIIO::ImageCache::ImageHandle* handle_;
  mutable std::atomic<bool> lost_{false};
};

// The header of a file whose every texel could be read, alpha left out where it is 1 everywhere. A damaged file is
// found now and not in the midst of rendering.
ImageFileHeader scan_by_bands(const std::string& path) {
  bool opaque = true;
  ImageFileHeader header =
      scan_image_file(path, [&](const ImageFileHeader& of_file, const std::vector<std::byte>& samples) {
        opaque = opaque && is_opaque(of_file, samples);
      });
  if (opaque) header.alpha_channel = -1;
  return header;
}

}  // namespace

struct TextureLibrary::State {
  std::uint64_t limit = 0;
  std::mutex mutex;
  std::uint64_t resident = 0;
  std::map<std::string, std::shared_ptr<const TexelArray>> whole_files;
  std::map<std::string, ImageFileHeader> cached_files;
  std::shared_ptr<OIIO::ImageCache> cache;
};

TextureLibrary::TextureLibrary(std::uint64_t limit_bytes) : state_(std::make_unique<State>()) {
  state_->limit = limit_bytes;
}

TextureLibrary::~TextureLibrary() = default;

std::shared_ptr<const TextureFile> TextureLibrary::open(const std::string& path, const TextureOptions& options) {
  const std::lock_guard lock(state_->mutex);
  if (const auto found = state_->whole_files.find(path); found != state_->whole_files.end()) {
    return make_texture(found->second, options);
  }
  auto cached = state_->cached_files.find(path);
  if (cached == state_->cached_files.end()) {
    const ImageFileHeader header = read_image_header(path);
    const std::uint64_t bytes = static_cast<std::uint64_t>(header.width) * static_cast<std::uint64_t>(header.height) *
                                static_cast<std::uint64_t>(header.channels) * size_of(header.type);
    const bool fits = state_->limit == 0 || state_->resident + bytes <= state_->limit / 4 * 3;
    if (fits || !CachedTexture::can_hold(header)) {
      const auto texels = read_texels(path);
      state_->resident += texels->samples.size();
      state_->whole_files[path] = texels;
      return make_texture(texels, options);
    }
    if (!state_->cache) {
      state_->cache = make_cache(state_->limit / 4);
      inform(fmt::format("textures do not fit into the {:.1f} MB they may hold; from {} on they are read by tiles",
                         static_cast<double>(state_->limit) / kMegabyte, path));
    }
    cached = state_->cached_files.emplace(path, scan_by_bands(path)).first;
  }
  return std::make_shared<CachedTexture>(path, cached->second, state_->cache, options);
}

std::uint64_t TextureLibrary::resident_bytes() const {
  const std::lock_guard lock(state_->mutex);
  return state_->resident;
}

std::size_t TextureLibrary::cached_files() const {
  const std::lock_guard lock(state_->mutex);
  return state_->cached_files.size();
}

}  // namespace glowworm
