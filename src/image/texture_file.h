// Image files as textures: texels are stored as in the file, and decoded and filtered at each lookup.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "core/memory_budget.h"
#include "core/rgb.h"
#include "core/vec.h"
#include "image/image_file.h"

namespace glowworm {

/// Value of a texture outside the unit square.
enum class TextureWrap : std::uint8_t {
  repeat,
  clamp,
  mirror,  ///< every other copy is mirrored
  black    ///< zero; also for alpha, if the file has it
};

enum class TextureFilter : std::uint8_t { bilinear, nearest };

/// Encoding of the colour channels of a file. Alpha is always linear.
enum class TextureEncoding : std::uint8_t {
  automatic,  ///< from the file; by default sRGB for integers and linear for floats
  srgb,
  linear,  ///< for data: normals, roughness
  power    ///< linear = encoded^exponent
};

struct TextureOptions {
  TextureWrap wrap_u = TextureWrap::repeat, wrap_v = TextureWrap::repeat;
  TextureFilter filter = TextureFilter::bilinear;
  TextureEncoding encoding = TextureEncoding::automatic;
  float exponent = 2.2f;  ///< of TextureEncoding::power

  bool operator==(const TextureOptions&) const = default;
};

/// A texture made from a file. Lookups are thread-safe, and give the same bits for all kinds of storage.
class TextureFile {
 public:
  virtual ~TextureFile() = default;

  /// Linear colour at (u, v); grey files give equal r, g and b. v runs upwards: v = 0 is the lower edge of the last
  /// row. Texel centres are at (i + 0.5) / width. Coordinates that are not finite count as 0.
  RGB color(Vec2 uv) const;
  /// The alpha channel at (u, v); 1 if the file has none, or is opaque everywhere.
  float alpha(Vec2 uv) const;
  bool has_alpha() const { return has_alpha_; }
  int width() const { return width_; }
  int height() const { return height_; }
  /// Memory of the texels in bytes, shared with other textures of the same file; 0 if they are in a temporary file.
  virtual std::uint64_t memory_bytes() const = 0;

 protected:
  /// A decoded texel: linear colour and alpha.
  struct Texel {
    RGB color;
    float alpha = 1;
  };
  TextureFile(int width, int height, bool has_alpha, const TextureOptions& options)
      : width_(width), height_(height), has_alpha_(has_alpha), options_(options) {}

  /// Texels (x[0], y[0]), (x[1], y[0]), (x[0], y[1]), (x[1], y[1]). All indices are valid.
  virtual void fetch(const int x[2], const int y[2], Texel out[4]) const = 0;

 private:
  Texel look_up(Vec2 uv) const;

  int width_, height_;
  bool has_alpha_;
  TextureOptions options_;
};

/// Reads a file's texels: 1 or 3 colour channels and, last, alpha if it is not 1 everywhere. Throws Error as
/// read_image_file() does.
std::shared_ptr<const ImageFileData> read_texels(const std::string& path);

/// A texture of texels in memory. Several textures may share the texels.
/// @param texels with the channels of read_texels()
std::shared_ptr<const TextureFile> make_texture(std::shared_ptr<const ImageFileData> texels,
                                                const TextureOptions& options);

/// All textures of a scene. Each file is read once, and the memory of texels is limited. Thread-safe.
class TextureLibrary {
 public:
  /// @param limit_bytes memory for texels; 0: unlimited. Three quarters hold whole files. When they are full, the
  /// texels of further files go into one unnamed temporary file (TexelStore), whose cache uses the last quarter, but at
  /// least 1 MiB, from then on.
  /// @param budget in which texels and the memory for decoding are reserved; null: none. open() throws MemoryError if
  /// it has no room.
  explicit TextureLibrary(std::uint64_t limit_bytes = 0, std::shared_ptr<MemoryBudget> budget = nullptr);
  ~TextureLibrary();
  TextureLibrary(const TextureLibrary&) = delete;
  TextureLibrary& operator=(const TextureLibrary&) = delete;

  /// A texture of a file: the same object for the same options, while it is in use. It may outlive the library, and the
  /// file may be deleted. Throws Error as read_image_file() does. If the temporary file cannot be created or is full,
  /// the texels stay in memory beyond the limit, with a warning. If it cannot be read back, texels are magenta, with a
  /// warning.
  /// @param known_as the name by which the library identifies the file; empty: its path
  std::shared_ptr<const TextureFile> open(const std::string& path, const TextureOptions& options = {},
                                          const std::string& known_as = {});
  /// A texture of a file opened before under this name; null if there is none.
  std::shared_ptr<const TextureFile> find(const std::string& name, const TextureOptions& options = {}) const;

  /// Memory of whole files, bytes.
  std::uint64_t resident_bytes() const;
  /// Number of files whose texels are in the temporary file.
  std::size_t stored_files() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace glowworm
