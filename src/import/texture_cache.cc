#include "import/texture_cache.h"

#include <stdlib.h>  // mkdtemp
#include <strings.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <set>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

/// A texture file as the scene's images are asked for.
class FileImage final : public TextureImage {
 public:
  explicit FileImage(std::shared_ptr<const TextureFile> file) : file_(std::move(file)) {}
  RGB color(Vec2 uv) const override { return file_->color(uv); }
  float alpha(Vec2 uv) const override { return file_->alpha(uv); }
  bool has_alpha() const override { return file_->has_alpha(); }
  int width() const override { return file_->width(); }
  int height() const override { return file_->height(); }

 private:
  std::shared_ptr<const TextureFile> file_;
};

/// What stands for an image that cannot be read.
class MagentaImage final : public TextureImage {
 public:
  RGB color(Vec2) const override { return {1, 0, 1}; }
  float alpha(Vec2) const override { return 1; }
  bool has_alpha() const override { return false; }
  int width() const override { return 1; }
  int height() const override { return 1; }
};

/// A folder that is there for as long as this is.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "glowworm-XXXXXX").string();
    if (!mkdtemp(name.data())) {
      throw Error("no temporary folder could be made in " + std::filesystem::temp_directory_path().string(),
                  "Free space there, or set TMPDIR to another folder.");
    }
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The ending by which OpenImageIO finds the reader for what stands in memory.
const char* extension_of(std::span<const std::uint8_t> bytes) {
  const auto starts = [&](std::initializer_list<int> magic) {
    return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
  };
  if (starts({0x89, 'P', 'N', 'G'})) return ".png";
  if (starts({0xff, 0xd8, 0xff})) return ".jpg";
  if (starts({'R', 'I', 'F', 'F'})) return ".webp";
  if (starts({'D', 'D', 'S', ' '})) return ".dds";
  if (starts({0x76, 0x2f, 0x31, 0x01})) return ".exr";
  if (starts({'B', 'M'})) return ".bmp";
  return nullptr;
}

/// Opens what stands in memory by way of a file, since the library reads, and bounds the memory of, files.
std::shared_ptr<const TextureFile> open_bytes(TextureLibrary& library, const std::string& name,
                                              std::span<const std::uint8_t> bytes, const TextureOptions& options) {
  if (auto known = library.find(name, options)) return known;
  const char* extension = extension_of(bytes);
  if (!extension) throw Error("not a PNG, JPEG, WebP, DDS, EXR or BMP image");
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / (std::string("image") + extension);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw Error("no room to unpack it in " + folder.path().string());
  return library.open(file.string(), options, name);
}

/// The first line of an error about `name`, without the name in front, which the caller says himself.
std::string problem_of(const std::string& name, const std::string& message) {
  const std::string line = message.substr(0, message.find('\n'));
  return line.starts_with(name + ": ") ? line.substr(name.size() + 2) : line;
}

/// The entry of a folder that has this name but for capitals, the first of several in the order of their bytes; empty
/// where there is none.
std::filesystem::path entry_whatever_the_capitals(const std::filesystem::path& folder, const std::string& name) {
  std::error_code error;
  if (std::filesystem::exists(folder / name, error)) return folder / name;
  std::string found;
  std::filesystem::directory_iterator it(folder.empty() ? std::filesystem::path(".") : folder, error), end;
  for (; !error && it != end; it.increment(error)) {
    const std::string entry = it->path().filename().string();
    if (strcasecmp(entry.c_str(), name.c_str()) == 0 && (found.empty() || entry < found)) found = entry;
  }
  return found.empty() ? std::filesystem::path() : folder / found;
}

}  // namespace

struct TextureCache::State {
  explicit State(const ImportOptions& options, NoteCounter& notes)
      : library(options.texture_memory_bytes), notes(notes) {}

  TextureLibrary library;
  NoteCounter& notes;
  std::set<std::string> failed;
  std::shared_ptr<const TextureImage> magenta = std::make_shared<MagentaImage>();
};

TextureCache::TextureCache(const ImportOptions& options, NoteCounter& notes)
    : state_(std::make_unique<State>(options, notes)) {}
TextureCache::~TextureCache() = default;

std::shared_ptr<const TextureImage> TextureCache::missing(const std::string& name, const std::string& problem) {
  if (state_->failed.insert(name).second) {
    const std::string message = "texture '" + name + "' is magenta: " + problem_of(name, problem);
    warn(message);
    state_->notes.add(message);
  }
  return state_->magenta;
}

std::shared_ptr<const TextureImage> TextureCache::load_file(const std::string& path, const TextureOptions& options) {
  check_cancelled();
  if (state_->failed.contains(path)) return state_->magenta;
  try {
    return std::make_shared<FileImage>(state_->library.open(path, options));
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& e) {
    return missing(path, e.what());
  }
}

std::shared_ptr<const TextureImage> TextureCache::load_memory(const std::string& name,
                                                              std::span<const std::uint8_t> bytes,
                                                              const TextureOptions& options) {
  if (state_->failed.contains(name)) return state_->magenta;
  try {
    return std::make_shared<FileImage>(open_bytes(state_->library, name, bytes, options));
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& e) {
    return missing(name, e.what());
  }
}

std::string find_texture_file(const std::string& folder, const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code error;
  std::string slashed = name;
  std::replace(slashed.begin(), slashed.end(), '\\', '/');
  const fs::path first = fs::path(folder) / slashed;
  const fs::path file_name = fs::path(slashed).filename();
  for (const fs::path& candidate : {first, fs::path(folder) / name, fs::path(folder) / file_name}) {
    if (fs::is_regular_file(candidate, error)) return candidate.string();
  }
  for (const fs::path& relative : {fs::path(slashed), file_name}) {
    if (!relative.is_relative()) continue;
    fs::path found = folder;
    for (const fs::path& part : relative) {
      found = entry_whatever_the_capitals(found, part.string());
      if (found.empty()) break;
    }
    if (!found.empty() && fs::is_regular_file(found, error)) return found.string();
  }
  return first.string();
}

std::uint32_t add_image_node(std::vector<TextureNode>& textures, std::shared_ptr<const TextureImage> image) {
  TextureNode node;
  node.kind = TextureKind::image;
  node.image = std::move(image);
  textures.push_back(std::move(node));
  return static_cast<std::uint32_t>(textures.size() - 1);
}

}  // namespace glowworm
