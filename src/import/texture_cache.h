// Texture files of an import, each decoded once.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "image/texture_file.h"
#include "import/import.h"
#include "import/notes.h"
#include "scene/texture.h"

namespace glowworm {

/// Decodes textures for one import. What cannot be read becomes magenta, with a note; where the budget has no room,
/// MemoryError is thrown, and where the program cannot read any image, MissingLibrary.
class TextureCache {
 public:
  /// @param options the budget that textures take a part of, and whether they are read at once
  /// @param notes   takes what was wrong; must outlive the cache
  TextureCache(const ImportOptions& options, NoteCounter& notes);
  ~TextureCache();
  TextureCache(const TextureCache&) = delete;
  TextureCache& operator=(const TextureCache&) = delete;

  /// The texture in a file; never null. A file is decoded once, however it is wrapped.
  std::shared_ptr<const TextureImage> load_file(const std::string& path, const TextureOptions& options = {});
  /// The texture in an image file that stands in memory; never null. It counts as a file does.
  /// @param name tells it from others, and from the files, of this import, and names it in messages
  std::shared_ptr<const TextureImage> load_memory(const std::string& name, std::span<const std::uint8_t> bytes,
                                                  const TextureOptions& options = {});
  /// The same, but throws Error where the file cannot be read.
  std::shared_ptr<const TextureImage> load_needed_file(const std::string& path, const TextureOptions& options = {});
  /// What stands for an image that cannot be read: magenta. Notes `problem`.
  std::shared_ptr<const TextureImage> missing(const std::string& name, const std::string& problem);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The file that a scene in `folder` means by `name`: as written, with backslashes as slashes, in the folder itself
/// where the path before it does not exist here, or with other capitals. Where there is none, the first of these.
std::string find_texture_file(const std::string& folder, const std::string& name);

/// Adds a node that shows an image and returns its index.
std::uint32_t add_image_node(std::vector<TextureNode>& textures, std::shared_ptr<const TextureImage> image);

}  // namespace glowworm
