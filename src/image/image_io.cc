#include <cstring>
#include <utility>

#include "core/error.h"
#include "core/text.h"
#include "image/image.h"
#include "image/image_file.h"
#include "image/picture_memory.h"

namespace glowworm {

Image read_image(const std::string& path, Reservation& held) {
  const ImageFileHeader header = read_image_header(path);
  // Grey pictures get three channels more; a band of rows is decoded beside them.
  const std::uint64_t channels = static_cast<std::uint64_t>(header.channels) + (header.channels < 3 ? 3 : 0);
  const std::uint64_t row = static_cast<std::uint64_t>(header.width) * sizeof(float);
  held.grow(row * (static_cast<std::uint64_t>(header.height) * channels +
                   static_cast<std::uint64_t>(header.rows_at_once) * static_cast<std::uint64_t>(header.channels)));
  return read_image(path);
}

Image read_image(const std::string& path) {
  std::vector<std::vector<float>> planes;
  const auto add_rows = [&](const ImageFileHeader& header, const std::vector<std::byte>& samples) {
    planes.resize(static_cast<std::size_t>(header.channels));
    for (std::size_t c = 0; c < planes.size(); ++c) {
      // reserve() does not touch memory: rows that a damaged file lacks take none.
      planes[c].reserve(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height));
      const bool is_alpha = static_cast<int>(c) == header.alpha_channel;
      for (std::size_t at = c * sizeof(float); at < samples.size(); at += planes.size() * sizeof(float)) {
        float value;
        std::memcpy(&value, samples.data() + at, sizeof(float));
        planes[c].push_back(is_alpha ? value : header.transfer.decode(value));
      }
    }
  };
  const ImageFileHeader header = scan_image_file(path, true, add_rows);
  Image image(header.width, header.height);
  image.metadata = header.metadata;
  image.place = {header.x0, header.y0, header.whole_width, header.whole_height};
  for (std::size_t c = 0; c < planes.size(); ++c) image.add_channel(header.channel_names[c], std::move(planes[c]));
  if (!image.has_channel("R") && (image.has_channel("Y") || header.channels == 1)) {
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
  if (lower(path).ends_with(".hdr")) return write_hdr(path, image);
  if (lower(path).ends_with(".png")) return write_png(path, image, curve, exposure);
  throw Error({path}, "the ending does not say which kind of image file to write",
              "End the path in .exr (linear, all layers), .hdr (linear) or .png (8 bits, tone mapped).");
}

}  // namespace glowworm
