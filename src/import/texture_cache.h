// Texture files of an import, each decoded once.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "image/texture_file.h"
#include "import/import.h"
#include "import/notes.h"
#include "import/stand_in.h"
#include "scene/texture.h"

namespace glowworm {

/// Decodes the textures of one import. A texture that cannot be read becomes its stand-in, with a note. Throws
/// MemoryError if the budget is exceeded, and MissingReader if the program cannot read images at all.
class TextureCache {
 public:
  /// @param options the budget, of which textures may use a part, and whether textures are read lazily
  /// @param notes   receives problems; must outlive the cache
  TextureCache(const ImportOptions& options, NoteCounter& notes);
  ~TextureCache();
  TextureCache(const TextureCache&) = delete;
  TextureCache& operator=(const TextureCache&) = delete;

  /// The texture in a file; never null. Each file is decoded once, even with several options.
  std::shared_ptr<const TextureImage> load_file(const std::string& path, const TextureOptions& options = {},
                                                StandIn stand_in = StandIn::magenta);
  /// The texture in an image file in memory; never null. Treated like a file.
  /// @param name unique among the textures of this import; used in messages
  std::shared_ptr<const TextureImage> load_memory(const std::string& name, std::span<const std::uint8_t> bytes,
                                                  const TextureOptions& options = {},
                                                  StandIn stand_in = StandIn::magenta);
  /// As load_file(), but throws Error if the file cannot be read.
  std::shared_ptr<const TextureImage> load_needed_file(const std::string& path, const TextureOptions& options = {});
  /// The image that replaces one that cannot be read. Notes `problem`.
  std::shared_ptr<const TextureImage> missing(const std::string& name, const std::string& problem,
                                              StandIn stand_in = StandIn::magenta);

 private:
  struct State;
  /// What `read` returns, or the stand-in.
  template <typename Read>
  std::shared_ptr<const TextureImage> or_stand_in(const std::string& name, StandIn stand_in, const Read& read);

  std::unique_ptr<State> state_;
};

/// A texture of a file, or of texels in memory, for a scene.
std::shared_ptr<const TextureImage> texture_image(std::shared_ptr<const TextureFile> texels);

/// Finds the file that a scene in `folder` refers to by `name`. Tries the name with backslashes as slashes, as written,
/// and the file name alone; then ignores capitalisation. If there is no such file, returns the first of these.
std::string find_texture_file(const std::string& folder, const std::string& name);

}  // namespace glowworm
