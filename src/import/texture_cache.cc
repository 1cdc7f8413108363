#include "import/texture_cache.h"

#include <strings.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include "core/content_hash.h"
#include "core/error.h"
#include "core/log.h"
#include "core/memory_file.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

/// A texture that is read from a file.
class FileImage final : public TextureImage {
 public:
  explicit FileImage(std::shared_ptr<const TextureFile> file) : file_(std::move(file)) {}
  RGB color(Vec2 uv) const override { return file_->color(uv); }
  float alpha(Vec2 uv) const override { return file_->alpha(uv); }
  bool has_alpha() const override { return file_->has_alpha(); }
  int width() const override { return file_->width(); }
  int height() const override { return file_->height(); }
  /// Imports that share a library share its files.
  std::uint64_t identity() const override { return reinterpret_cast<std::uintptr_t>(file_.get()); }

 private:
  std::shared_ptr<const TextureFile> file_;
};

/// Replaces an image that cannot be read.
class PlainImage final : public TextureImage {
 public:
  explicit PlainImage(RGB color) : color_(color) {}
  RGB color(Vec2) const override { return color_; }
  float alpha(Vec2) const override { return 1; }
  bool has_alpha() const override { return false; }
  int width() const override { return 1; }
  int height() const override { return 1; }
  std::uint64_t identity() const override {
    ContentHash hash;
    hash.add(color_);
    return hash.value();
  }

 private:
  RGB color_;
};

RGB color_of(StandIn stand_in) {
  switch (stand_in) {
    case StandIn::magenta:
      break;
    case StandIn::one:
      return RGB(1.0f);
    case StandIn::none:
      return RGB(0.0f);
    case StandIn::flat_normal:
      return {0.5f, 0.5f, 1};
    case StandIn::along_tangent:
      return {1, 0.5f, 1};
  }
  return {1, 0, 1};
}

/// The first line of an error about `name`, without the leading name, which the caller adds.
std::string problem_of(const std::string& name, const std::string& message) {
  const std::string line = first_line(message);
  return line.starts_with(name + ": ") ? line.substr(name.size() + 2) : line;
}

/// The message about an image that cannot be read.
std::string message_about(const std::string& name, const std::string& problem, StandIn stand_in) {
  return "texture '" + name + (stand_in == StandIn::magenta ? "' is magenta: " : "' is left out: ") +
         problem_of(name, problem);
}

/// Passes data in memory to `read` as a file, because the library reads files and limits their memory.
template <typename Read>
auto as_a_file(std::span<const std::uint8_t> bytes, MemoryBudget& budget, const Read& read) {
  const Reservation room(budget, "image files", bytes.size());
  const MemoryFile file(bytes);
  try {
    return read(file.path());
  } catch (const MemoryError&) {
    throw;
  } catch (const MissingReader&) {
    throw;
  } catch (const Error& error) {
    throw Error(problem_of(file.path(), error.what()));
  }
}

/// A texture that is read on first use. If it cannot be read then, it is its stand-in, with a warning.
class LazyImage final : public TextureImage {
 public:
  using Open = std::function<std::shared_ptr<const TextureFile>()>;
  LazyImage(std::string name, const ImageFileHeader& header, StandIn stand_in, Open open)
      : name_(std::move(name)),
        stand_in_(stand_in),
        width_(header.width),
        height_(header.height),
        has_alpha_(header.alpha_channel >= 0),
        open_(std::move(open)) {}
  RGB color(Vec2 uv) const override { return file() ? file_->color(uv) : color_of(stand_in_); }
  float alpha(Vec2 uv) const override { return file() ? file_->alpha(uv) : 1; }
  bool has_alpha() const override { return has_alpha_; }
  int width() const override { return width_; }
  int height() const override { return height_; }

 private:
  const TextureFile* file() const {
    std::call_once(once_, [this] {
      try {
        file_ = open_();
      } catch (const std::exception& error) {
        warn(message_about(name_, error.what(), stand_in_));
      }
    });
    return file_.get();
  }

  std::string name_;
  StandIn stand_in_;
  int width_, height_;
  bool has_alpha_;
  Open open_;
  mutable std::once_flag once_;
  mutable std::shared_ptr<const TextureFile> file_;
};

/// The folder entry with this name, ignoring capitalisation; the first in byte order if there are several, empty if
/// there is none.
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
      : budget(options.budget),
        library(options.textures ? options.textures : texture_library(options.budget)),
        notes(notes),
        lazy(options.lazy_textures) {}

  std::shared_ptr<const TextureImage> read_file(const std::string& path, const TextureOptions& options,
                                                StandIn stand_in) const {
    if (!lazy) return texture_image(library->open(path, options));
    return std::make_shared<LazyImage>(path, read_image_header(path), stand_in,
                                       [kept = library, path, options] { return kept->open(path, options); });
  }

  std::shared_ptr<const TextureImage> read_memory(const std::string& name, std::span<const std::uint8_t> bytes,
                                                  const TextureOptions& options, StandIn stand_in) {
    const auto open = [kept = library, name, options, room = budget](std::span<const std::uint8_t> from) {
      if (auto known = kept->find(name, options)) return known;
      return as_a_file(from, *room, [&](const std::string& file) { return kept->open(file, options, name); });
    };
    if (!lazy) return texture_image(open(bytes));
    auto& kept = unread[name];
    if (!kept) kept = std::make_shared<std::vector<std::uint8_t>>(bytes.begin(), bytes.end());
    auto header = headers.find(name);
    if (header == headers.end()) header = headers.emplace(name, as_a_file(bytes, *budget, read_image_header)).first;
    return std::make_shared<LazyImage>(name, header->second, stand_in, [open, from = kept] { return open(*from); });
  }

  std::shared_ptr<MemoryBudget> budget;
  std::shared_ptr<TextureLibrary> library;
  NoteCounter& notes;
  bool lazy;
  std::map<std::string, std::shared_ptr<const std::vector<std::uint8_t>>>
      unread;                                      // files in memory that were not read yet (lazy textures)
  std::map<std::string, ImageFileHeader> headers;  // their headers
  std::map<std::string, std::string> failed;       // problems by name
  std::set<std::string> noted;
};

std::shared_ptr<TextureLibrary> texture_library(const std::shared_ptr<MemoryBudget>& budget) {
  return std::make_shared<TextureLibrary>(budget->limit() / 4, budget);
}

TextureCache::TextureCache(const ImportOptions& options, NoteCounter& notes)
    : state_(std::make_unique<State>(options, notes)) {}
TextureCache::~TextureCache() = default;

std::shared_ptr<const TextureImage> TextureCache::missing(const std::string& name, const std::string& problem,
                                                          StandIn stand_in) {
  const std::string note = message_about(name, state_->failed.emplace(name, problem).first->second, stand_in);
  if (state_->noted.insert(note).second) state_->notes.add(note);
  return std::make_shared<PlainImage>(color_of(stand_in));
}

template <typename Read>
std::shared_ptr<const TextureImage> TextureCache::or_stand_in(const std::string& name, StandIn stand_in,
                                                              const Read& read) {
  if (state_->failed.contains(name)) return missing(name, {}, stand_in);
  try {
    return read();
  } catch (const MemoryError&) {
    throw;
  } catch (const MissingReader&) {
    throw;
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& e) {
    return missing(name, e.what(), stand_in);
  }
}

std::shared_ptr<const TextureImage> TextureCache::load_file(const std::string& path, const TextureOptions& options,
                                                            StandIn stand_in) {
  check_cancelled();
  return or_stand_in(path, stand_in, [&] { return state_->read_file(path, options, stand_in); });
}

std::shared_ptr<const TextureImage> TextureCache::load_needed_file(const std::string& path,
                                                                   const TextureOptions& options) {
  return state_->read_file(path, options, StandIn::magenta);
}

std::shared_ptr<const TextureImage> TextureCache::load_memory(const std::string& name,
                                                              std::span<const std::uint8_t> bytes,
                                                              const TextureOptions& options, StandIn stand_in) {
  return or_stand_in(name, stand_in, [&] { return state_->read_memory(name, bytes, options, stand_in); });
}

std::shared_ptr<const TextureImage> texture_image(std::shared_ptr<const TextureFile> texels) {
  return std::make_shared<FileImage>(std::move(texels));
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

}  // namespace glowworm
