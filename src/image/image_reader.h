// Access to OpenImageIO through a shared library, which is loaded when the first file is read. OpenImageIO has some 250
// dependencies, whose loading takes longer than a small render.
#pragma once
#include <memory>
#include <string>

#include "image/image_file.h"

namespace glowworm {

/// An open image file. Errors are results, not exceptions: the library contains no code of other rooms.
class ImageReader {
 public:
  virtual ~ImageReader() = default;

  const ImageFileHeader& header() const { return header_; }
  /// Slices of a volume; 1 for a picture, 0 where the file does not say.
  int depth() const { return depth_; }
  /// Rows of a tile; 0 where the file is not tiled.
  int tile_height() const { return tile_height_; }
  /// Reads rows [first, last), which begin at a tile's first row and end at a tile's last or the picture's, as samples
  /// of a type. Returns whether all came.
  virtual bool read_rows(int first, int last, SampleType type, void* samples) = 0;
  /// Error messages of the reader since the last call.
  virtual std::string report() = 0;

 protected:
  ImageFileHeader header_;
  int depth_ = 0, tile_height_ = 0;
};

/// Opens a file by the reader of a format (ImageFormat::plugin) alone; null where it cannot be read as an image, and
/// then `failure` says why. Throws Error where the shared library is not there.
std::unique_ptr<ImageReader> open_image_reader(const std::string& path, const char* plugin, std::string& failure);

/// The function of the shared library that does it, by its name there. The caller deletes what it returns.
using OpenImageFunction = ImageReader*(const char* path, const char* plugin, std::string& failure);
inline constexpr const char* kOpenImageFunction = "glowworm_open_image";

}  // namespace glowworm
