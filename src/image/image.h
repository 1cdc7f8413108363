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
#include "glowworm/picture.h"
#include "image/tone_map.h"

namespace glowworm {

/// One plane of numbers, named as in an EXR file: "R", "albedo.G", "depth.Z".
struct ImageChannel {
  std::string name;
  std::vector<float> samples;  ///< row-major, first row on top; width * height numbers
};

/// Position of a picture that is a part of a larger one; all zero: it is a whole picture.
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
  /// An empty picture without channels. Throws Error if a side is not positive.
  Image(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t pixel_count() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }

  const std::vector<ImageChannel>& channels() const { return channels_; }
  bool has_channel(std::string_view name) const;
  /// Samples of the channel with this name. Throws Error, which lists the channels, if there is none.
  std::span<const float> channel(std::string_view name) const;
  std::span<float> channel(std::string_view name);

  /// Adds a channel of zeros, or replaces an existing one, and returns its samples. Their address is stable until the
  /// channel is replaced.
  std::span<float> add_channel(const std::string& name);
  /// Adds or replaces a channel of these samples. Throws Error if their number is not pixel_count().
  std::span<float> add_channel(const std::string& name, std::vector<float> samples);
  /// Adds a layer of three channels R, G, B; the layer "" is the beauty. Throws Error if the size is not pixel_count().
  void add_rgb(std::string_view layer, std::span<const RGB> pixels);
  /// Adds a layer of three channels X, Y, Z.
  void add_vec3(std::string_view layer, std::span<const Vec3> pixels);
  /// Adds one channel: "depth.Z", "A".
  void add_scalar(const std::string& name, std::span<const float> pixels);

  /// Linear RGB of a layer as an array of pixels; the layer "" is the beauty.
  std::vector<RGB> rgb(std::string_view layer = "") const;

  /// EXR files store the place as data window and the whole picture as display window. PNG files store only the part.
  PicturePlace place;

  /// Metadata in the header of a file: settings, version, seed, time.
  std::map<std::string, std::string> metadata;
  /// Matrices in the header of EXR files, by rows. Points are row vectors, multiplied from the left.
  std::map<std::string, std::array<float, 16>> matrices;
  /// The beauty over radiance in W sr^-1 m^-2, for EXPOSURE in HDR files and whiteLuminance in EXR files; 0: it shows
  /// something else.
  float radiance_scale = 0;

 private:
  int width_ = 0, height_ = 0;
  std::vector<ImageChannel> channels_;
};

/// A layer of a picture as the beauty of a new one: R, G, B or X, Y, Z become R, G, B; one channel becomes grey. "" is
/// the beauty. Throws Error, which lists the layers, if there is none with this name.
Image layer_of(const Image& image, std::string_view layer);

/// Pixels [x0, x1) x [y0, y1) of the whole picture that contains `image`. Throws Error if some of them are missing.
Image cut(const Image& image, int x0, int y0, int x1, int y1);

/// Crops two pictures to their common pixels, if both are parts of pictures of equal size.
void cut_to_common_part(Image& a, Image& b);

/// Reads the first picture of any supported image file. Files of integers are converted to linear numbers from their
/// colour space, sRGB by default. In a grey picture R, G and B are equal; alpha stays as stored. Throws Error if the
/// file is missing, truncated, empty, too large for the machine's memory, or not an image.
Image read_image(const std::string& path);

/// Throws Error if the picture is empty.
void check_not_empty(const std::string& path, const Image& image);

using ExrPrecision = api::Precision;

/// Writes all channels and the metadata to one part of an EXR file (ZIP compression), whole or not at all (see
/// AtomicFile). Throws Error if it cannot be written.
void write_exr(const std::string& path, const Image& image, ExrPrecision precision = ExrPrecision::half);

/// Writes the beauty and the metadata as an 8-bit sRGB PNG, whole or not at all.
/// @param exposure in stops: the picture is multiplied by 2^exposure before the curve
void write_png(const std::string& path, const Image& image, ToneCurve curve = ToneCurve::filmic, float exposure = 0);

/// The bytes of the file that write_png() writes. @param path for errors
std::string png_bytes(const std::string& path, const Image& image, ToneCurve curve = ToneCurve::filmic,
                      float exposure = 0);

/// A PNG file of 8-bit sRGB codes. Throws Error where memory is short.
/// @param channels 3, or 4 with alpha; @param codes `channels` bytes a pixel, row-major, first row on top
std::string encode_png(int width, int height, int channels, std::vector<std::uint8_t> codes,
                       const std::map<std::string, std::string>& metadata);

/// Key of the view in the metadata, as radiance_view_text() writes it; VIEW in HDR files.
inline constexpr const char* kRadianceView = "glowworm:view";

/// Writes the beauty as a Radiance picture (RGBE) with its view and exposure, whole or not at all.
void write_hdr(const std::string& path, const Image& image);

/// Writes ".exr" files as write_exr() does, ".hdr" files as write_hdr() does and ".png" files as write_png() does.
/// Throws Error for other extensions.
void write_image(const std::string& path, const Image& image, ToneCurve curve = ToneCurve::filmic, float exposure = 0);

}  // namespace glowworm
