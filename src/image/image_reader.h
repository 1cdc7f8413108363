// Access to OpenImageIO and giflib through a module that is loaded when the first file is read. OpenImageIO has some
// 250 dependencies, and loading them takes longer than a small render.
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
  /// Slices of a volume; 1 for a picture, 0 if the file does not tell.
  int depth() const { return depth_; }
  /// Rows of a tile; 0 if the file is not tiled.
  int tile_height() const { return tile_height_; }
  /// Whether the reader unpacks and holds all rows when it reads the first.
  bool unpacks_whole() const { return unpacks_whole_; }
  /// Reads rows [first, last) as samples of a type. The range must start at the first row of a tile, and end at the
  /// last row of a tile or of the picture. Returns whether all rows were read.
  virtual bool read_rows(int first, int last, SampleType type, void* samples) = 0;
  /// Error messages of the reader since the last call.
  virtual std::string report() = 0;

 protected:
  ImageFileHeader header_;
  int depth_ = 0, tile_height_ = 0;
  bool unpacks_whole_ = false;
};

/// Opens a file by the reader of one format (ImageFormat::plugin). If it cannot be read as an image, returns null and
/// sets `failure` to the reason. Throws MissingLibrary if the module cannot be loaded.
std::unique_ptr<ImageReader> open_image_reader(const std::string& path, const char* plugin, std::string& failure);

/// The module's function that opens files, by its exported name. The caller deletes the result.
using OpenImageFunction = ImageReader*(const char* path, const char* plugin, std::string& failure);
inline constexpr const char* kOpenImageFunction = "glowworm_open_image";

}  // namespace glowworm
