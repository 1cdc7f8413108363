#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <utility>

#include "core/error.h"
#include "core/log.h"
#include "image/texel_decoder.h"
#include "image/texel_store.h"
#include "image/texture_file.h"

namespace glowworm {

namespace {

constexpr std::uint64_t kMegabyte = 1u << 20;
// With a smaller cache, lookups would read from disk nearly every time.
constexpr std::uint64_t kMinCache = kMegabyte;

// A texture whose texels are read block by block from a store.
class StoredTexture final : public TextureFile {
 public:
  StoredTexture(std::string name, const StoredTexels& texels, std::shared_ptr<TexelStore> store,
                const TextureOptions& options)
      : TextureFile(texels.header.width, texels.header.height, texels.header.alpha_channel >= 0, options),
        name_(std::move(name)),
        texels_(texels),
        decoder_(texels.header.type, resolve_encoding(options, texels.header.transfer)),
        store_(std::move(store)) {}

  std::uint64_t memory_bytes() const override { return 0; }

 protected:
  void fetch(const int x[2], const int y[2], Texel out[4]) const override {
    for (int i = 0; i < 4; ++i) out[i] = fetch_one(x[i % 2], y[i / 2]);
  }

 private:
  Texel fetch_one(int x, int y) const {
    alignas(8) std::byte samples[4 * sizeof(float)];
    try {
      store_->read(texels_.block_of(x, y), texels_.offset_of(x, y),
                   std::span(samples, static_cast<std::size_t>(texels_.texel_bytes)));
    } catch (const Error& error) {
      // Lookups are called from libraries that do not support exceptions.
      if (!lost_.exchange(true)) {
        warn(fmt::format("{}: some of its texels are magenta ({})", name_, first_line(error.what())));
      }
      return {{1, 0, 1}, 1};
    }
    const bool grey = texels_.header.channels < 3;
    Texel texel;
    texel.color = decoder_.color(samples, 0, grey);
    if (has_alpha()) texel.alpha = decoder_.alpha(samples, grey ? 1 : 3);
    return texel;
  }

  std::string name_;
  StoredTexels texels_;
  TexelDecoder decoder_;
  std::shared_ptr<TexelStore> store_;
  mutable std::atomic<bool> lost_{false};
};

}  // namespace

struct TextureLibrary::State {
  State(std::uint64_t limit_bytes, std::shared_ptr<MemoryBudget> given)
      : limit(limit_bytes), budget(given ? std::move(given) : std::make_shared<MemoryBudget>()) {}

  std::uint64_t limit;
  std::shared_ptr<MemoryBudget> budget;
  Reservation held{*budget, "textures", 0};
  std::mutex mutex;
  std::uint64_t resident = 0;
  std::map<std::string, std::shared_ptr<const ImageFileData>> whole;
  std::map<std::string, StoredTexels> stored;
  std::shared_ptr<TexelStore> store;
  std::uint64_t blocks = 0;  // used blocks of the store
  bool said_problem = false, reserved_cache = false;
  /// Textures in use, by the names of their files.
  std::multimap<std::string, std::pair<TextureOptions, std::weak_ptr<const TextureFile>>> in_use;

  std::shared_ptr<const TextureFile> find(const std::string& name, const TextureOptions& options) {
    const auto [first, last] = in_use.equal_range(name);
    const auto made = std::find_if(first, last, [&](const auto& entry) { return entry.second.first == options; });
    if (made != last)
      if (std::shared_ptr<const TextureFile> texture = made->second.second.lock()) return texture;
    std::shared_ptr<const TextureFile> texture = make(name, options);
    if (made != last)
      made->second.second = texture;
    else if (texture)
      in_use.emplace(name, std::pair(options, std::weak_ptr(texture)));
    return texture;
  }

  std::shared_ptr<const TextureFile> make(const std::string& name, const TextureOptions& options) const {
    if (const auto found = whole.find(name); found != whole.end()) return make_texture(found->second, options);
    if (const auto found = stored.find(name); found != stored.end()) {
      return std::make_shared<StoredTexture>(name, found->second, store, options);
    }
    return nullptr;
  }

  bool fits(const ImageFileHeader& header) const {
    return limit == 0 || resident + header.bytes_of_rows(header.height) <= limit / 4 * 3;
  }

  // Creates the store. Returns the reason if that fails, otherwise "".
  std::string ensure_store(const std::string& name) {
    if (store) return "";
    try {
      if (!std::exchange(reserved_cache, true)) held.grow(std::max(limit / 4, kMinCache));
      store = std::make_shared<TexelStore>(std::max(limit / 4, kMinCache));
    } catch (const MemoryError&) {
      throw;
    } catch (const Error& error) {
      return error.what();
    }
    inform(fmt::format("textures do not fit into the {:.1f} MB they may hold; from {} on they are in a temporary file",
                       static_cast<double>(limit) / kMegabyte, name));
    return "";
  }

  // Decodes a picture into the store. Returns whether that succeeded.
  bool put_into_store(const std::string& path, const std::string& name) {
    std::string problem = ensure_store(name);
    if (problem.empty()) {
      StoringOutcome outcome = store_texels(path, *store, blocks);
      if (outcome.problem.empty()) {
        blocks += outcome.texels.blocks;
        stored.emplace(name, outcome.texels);
        return true;
      }
      problem = std::move(outcome.problem);
    }
    if (!std::exchange(said_problem, true)) {
      warn(
          fmt::format("{} and perhaps more textures are held in memory, beyond what they may take: {}", name, problem));
    }
    return false;
  }
};

TextureLibrary::TextureLibrary(std::uint64_t limit_bytes, std::shared_ptr<MemoryBudget> budget)
    : state_(std::make_unique<State>(limit_bytes, std::move(budget))) {}

TextureLibrary::~TextureLibrary() = default;

std::shared_ptr<const TextureFile> TextureLibrary::find(const std::string& name, const TextureOptions& options) const {
  const std::lock_guard lock(state_->mutex);
  return state_->find(name, options);
}

std::shared_ptr<const TextureFile> TextureLibrary::open(const std::string& path, const TextureOptions& options,
                                                        const std::string& known_as) {
  const std::string& name = known_as.empty() ? path : known_as;
  const std::lock_guard lock(state_->mutex);
  if (auto known = state_->find(name, options)) return known;
  const ImageFileHeader header = read_image_header(path);
  const Reservation decoding(*state_->budget, "decoding of a texture", header.bytes_of_rows(header.rows_at_once));
  if (state_->fits(header) || !state_->put_into_store(path, name)) {
    state_->held.grow(header.bytes_of_rows(header.height));
    auto texels = read_texels(path);
    state_->resident += texels->samples.size();
    state_->whole[name] = std::move(texels);
  }
  return state_->find(name, options);
}

std::uint64_t TextureLibrary::resident_bytes() const {
  const std::lock_guard lock(state_->mutex);
  return state_->resident;
}

std::size_t TextureLibrary::stored_files() const {
  const std::lock_guard lock(state_->mutex);
  return state_->stored.size();
}

}  // namespace glowworm
