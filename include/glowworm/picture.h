// Pictures: layers of floats, in memory and in files, and measures of their difference.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "glowworm/error.h"

namespace glowworm::api {

/// Name of the layer that is the picture itself; the others are the AOVs.
inline constexpr const char* kImageLayer = "image";

/// A picture: layers of floats.
struct Picture {
  struct Layer {
    std::string name;  ///< kImageLayer, or the name of an AOV
    /// Letters of the channels: "RGB" of colours, "XYZ" of vectors, "Z" of depth.
    std::string channels;
    /// height * width * channels.size(): row by row from the top, the channels of a pixel side by side. Radiance in
    /// W sr^-1 m^-2, depth in metres, positions in metres from metadata "glowworm:origin".
    std::vector<float> samples;
  };
  int width = 0, height = 0;              ///< pixels
  int x0 = 0, y0 = 0;                     ///< of a part of a picture: its upper left pixel in the whole
  int whole_width = 0, whole_height = 0;  ///< of a part of a picture: pixels of the whole; else 0
  std::vector<Layer> layers;
  /// Settings, version and time of a render, and the names of a Cryptomatte.
  std::map<std::string, std::string> metadata;

  /// The layer of that name. Throws Error, which lists the existing names, if there is none.
  const Layer& layer(const std::string& name = kImageLayer) const;
};

/// Reads any image file that the command line reads. Layers of an EXR file keep their names.
/// Throws Error if the file is missing, damaged or no image.
Picture read_picture(const std::string& path);

/// How numbers are stored in EXR files.
enum class Precision : std::uint8_t {
  half,    ///< 16-bit floats, but 32-bit ones in layers of depths, positions, ids, and numbers beyond their range
  single,  ///< 32-bit floats: the picture's own numbers
};

/// Writes a picture in the format of the path's extension: .exr with all layers, linear; .png with the image layer and
/// a filmic tone curve. The file appears whole or not at all. Throws Error if it cannot be written.
/// @param exposure of a PNG file, stops
/// @param precision of an EXR file
void write_picture(const std::string& path, const Picture& picture, float exposure = 0,
                   Precision precision = Precision::single);

/// The bytes of a PNG file of a layer of one or three channels, with a filmic tone curve.
/// @param exposure stops
std::string png_of(const Picture& picture, const std::string& layer = kImageLayer, float exposure = 0);

/// The exposure, in stops, that takes the logarithmic mean of the image's luminance to 18% grey.
float automatic_exposure(const Picture& picture);

/// The difference between a picture I and its reference R; means are over pixels and channels.
struct Comparison {
  double mse = 0;                     ///< mean of (I - R)^2
  double relative_mse = 0;            ///< mean of (I - R)^2 / (R^2 + 0.01)
  double relative_rmse = 0;           ///< its square root
  double psnr_db = 0;                 ///< 10 log10(P^2 / mse), P the largest number of R; infinite if mse is 0
  double luminance_ratio = 0;         ///< mean of I over mean of R, of the luminance
  double rgb_ratio[3] = {};           ///< the same of each channel
  double largest_difference = 0;      ///< greatest |I - R|
  std::size_t pixels = 0;             ///< compared
  std::size_t pixels_not_finite = 0;  ///< in either picture; not compared
};

/// Compares a layer of two pictures of one size. Throws Error if the sizes differ, a layer is missing, or no pixel is
/// finite in both.
/// @param leave_out share in [0, 1) of the pixels with the largest error that the means of squares leave out
Comparison compare(const Picture& picture, const Picture& reference, const std::string& layer = kImageLayer,
                   double leave_out = 0);

}  // namespace glowworm::api
