// Access to OpenImageIO and giflib through the program glowworm-reader. They crash on damaged files, and OpenImageIO
// has some 250 dependencies, which take longer to load than a small render.
#pragma once
#include <memory>
#include <string>

#include "image/image_file.h"
#include "image/image_format.h"

namespace glowworm {

/// An open image file.
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

/// Opens a file in a process of the program glowworm-reader. Each process serves one open file at a time, and many one
/// after the other; there are as many as files were open at once. Any thread may call this. If the file cannot be read
/// as an image, returns null and sets `failure` to the reason. This and the result's read_rows() throw Error if the
/// process crashes or reaches a limit, and Cancelled as check_cancelled() does; this throws MissingReader if the
/// program cannot be started.
/// @param format of a plugin, ImageFormat::plugin
std::unique_ptr<ImageReader> open_image_reader(const std::string& path, const ImageFormat& format,
                                               std::string& failure);

}  // namespace glowworm
