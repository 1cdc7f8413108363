#include <cstring>

#include "core/error.h"
#include "core/text.h"
#include "image/image.h"
#include "image/image_file.h"

namespace glowworm {

Image read_image(const std::string& path) {
  const ImageFileData data = read_image_file(path, true);
  const ImageFileHeader& header = data.header;
  Image image(header.width, header.height);
  image.metadata = header.metadata;
  image.place = {header.x0, header.y0, header.whole_width, header.whole_height};
  const auto channels = static_cast<std::size_t>(header.channels);
  for (std::size_t c = 0; c < channels; ++c) {
    const bool is_alpha = static_cast<int>(c) == header.alpha_channel;
    const std::span<float> plane = image.add_channel(header.channel_names[c]);
    for (std::size_t i = 0; i < plane.size(); ++i) {
      float value;
      std::memcpy(&value, data.samples.data() + (i * channels + c) * sizeof(float), sizeof(float));
      plane[i] = is_alpha ? value : header.transfer.decode(value);
    }
  }
  if (!image.has_channel("R") && (image.has_channel("Y") || channels == 1)) {
    const std::string grey = image.has_channel("Y") ? "Y" : header.channel_names[0];
    const std::vector<float> samples(image.channel(grey).begin(), image.channel(grey).end());
    for (const char* name : {"R", "G", "B"}) image.add_scalar(name, samples);
  }
  return image;
}

void check_not_empty(const std::string& path, const Image& image) {
  if (image.pixel_count() == 0 || image.channels().empty()) {
    throw Error({path}, "the picture to write has no pixels or no channels");
  }
}

void write_image(const std::string& path, const Image& image, ToneCurve curve, float exposure) {
  if (lower(path).ends_with(".exr")) return write_exr(path, image);
  if (lower(path).ends_with(".png")) return write_png(path, image, curve, exposure);
  throw Error({path}, "the ending does not say which kind of image file to write",
              "End the path in .exr (linear, all layers) or .png (8 bits, tone mapped).");
}

}  // namespace glowworm
