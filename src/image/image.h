// Pictures in memory and in files.
#pragma once
#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/rgb.h"
#include "core/vec.h"
#include "image/tone_map.h"

namespace glowworm {

/// One plane of numbers with the name that it has in an EXR file: "R", "albedo.G", "depth.Z".
struct ImageChannel {
  std::string name;
  std::vector<float> samples;  ///< row-major, the first row on top; width * height of them
};

/// Where a picture lies in a larger one that it is a part of; all zero: it is a whole one.
struct PicturePlace {
  int x0 = 0, y0 = 0;                     ///< the upper left pixel, in pixels of the whole
  int whole_width = 0, whole_height = 0;  ///< pixels of the whole
  bool operator==(const PicturePlace&) const = default;
};

/// A picture made of named planes of floats. The beauty's channels are R, G, B (and A); another layer's are
/// "layer.R", "normal.X" and so on, which is how compositing programs and viewers group them.
class Image {
 public:
  Image() = default;
  /// A picture without channels; throws Error where a side is not positive.
  Image(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t pixel_count() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }

  const std::vector<ImageChannel>& channels() const { return channels_; }
  bool has_channel(std::string_view name) const;
  /// Samples of the channel of that name; throws Error, which names the existing ones, if there is none.
  std::span<const float> channel(std::string_view name) const;
  std::span<float> channel(std::string_view name);

  /// Adds a channel of zeros (or replaces one of that name) and returns its samples, whose address is stable until it
  /// is replaced.
  std::span<float> add_channel(const std::string& name);
  /// Adds a layer of three channels R, G, B; the layer "" is the beauty. Throws Error where the size is not
  /// pixel_count().
  void add_rgb(std::string_view layer, std::span<const RGB> pixels);
  /// Adds a layer of three channels X, Y, Z.
  void add_vec3(std::string_view layer, std::span<const Vec3> pixels);
  /// Adds one channel: "depth.Z", "A".
  void add_scalar(const std::string& name, std::span<const float> pixels);

  /// Linear RGB of a layer as an array of pixels; the layer "" is the beauty.
  std::vector<RGB> rgb(std::string_view layer = "") const;

  /// In EXR files the place is the data window, and the whole the display window; PNG files have only the part.
  PicturePlace place;

  /// Metadata in the header of a file: settings, version, seed, time.
  std::map<std::string, std::string> metadata;
  /// Matrices of the header of EXR files, in rows: a point is a row that they are multiplied to from the right.
  std::map<std::string, std::array<float, 16>> matrices;

 private:
  int width_ = 0, height_ = 0;
  std::vector<ImageChannel> channels_;
};

/// The layer of a picture as the beauty of another: R, G, B or X, Y, Z become R, G, B; one channel becomes grey. "" is
/// the beauty. Throws Error that lists the layers there are.
Image layer_of(const Image& image, std::string_view layer);

/// Pixels [x0, x1) x [y0, y1) of the whole picture that `image` is, or is a part of. Throws Error where they are not
/// all there.
Image cut(const Image& image, int x0, int y0, int x1, int y1);

/// Cuts two pictures to the pixels that both have, where they are parts of wholes of one size.
void cut_to_common_part(Image& a, Image& b);

/// Reads the first picture of any supported image file. Files of integers are converted to linear numbers from their
/// colour space, sRGB by default. In a grey picture R, G and B are equal; alpha stays as stored. Throws Error if the
/// file is missing, truncated, empty, too large for the machine's memory, or not an image.
Image read_image(const std::string& path);

/// Throws Error if the picture is empty.
void check_not_empty(const std::string& path, const Image& image);

/// How numbers are stored in an EXR file.
enum class ExrPrecision {
  half,   ///< 16-bit floats, clamped to their range. The channel "depth.Z" stays 32-bit.
  single  ///< 32-bit floats
};

/// Writes all channels and the metadata into one part of an EXR file (ZIP compression), whole or not at all (see
/// AtomicFile). Throws Error where it cannot be written.
void write_exr(const std::string& path, const Image& image, ExrPrecision precision = ExrPrecision::half);

/// Writes the beauty and the metadata as an 8-bit sRGB PNG, whole or not at all.
/// @param exposure in stops: the picture is multiplied by 2^exposure before the curve
void write_png(const std::string& path, const Image& image, ToneCurve curve = ToneCurve::filmic, float exposure = 0);

/// Writes by the ending of the path: ".exr" as by write_exr, ".png" as by write_png; throws Error for all others.
void write_image(const std::string& path, const Image& image, ToneCurve curve = ToneCurve::filmic, float exposure = 0);

}  // namespace glowworm
