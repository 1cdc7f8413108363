#include "image/reader/gif_reader.h"

#include <gif_lib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace glowworm {
namespace {

using Rgba = std::array<std::uint8_t, 4>;

std::string message_of(int error) {
  const char* text = GifErrorString(error);
  return text ? text : "damaged";
}

/// The row of an interlaced picture of so many rows that comes at a place in the file.
int interlaced_row(int place, int rows) {
  struct Pass {
    int first, step;
  };
  for (const auto [first, step] : {Pass{0, 8}, Pass{4, 8}, Pass{2, 4}, Pass{1, 2}}) {
    const int count = rows > first ? (rows - first - 1) / step + 1 : 0;
    if (place < count) return first + place * step;
    place -= count;
  }
  return rows;
}

class GifReader : public ImageReader {
 public:
  explicit GifReader(GifFileType* file) : file_(file) {
    header_.width = file->SWidth;
    header_.height = file->SHeight;
    header_.channels = 4;
    header_.alpha_channel = 3;
    header_.type = SampleType::uint8;
    header_.transfer = {TransferFunction::Kind::srgb, 1};
    header_.channel_names = {"R", "G", "B", "A"};
    depth_ = 1;
  }
  ~GifReader() override { DGifCloseFile(file_, nullptr); }

  /// Reads all rows, once: the format does not list them in order.
  bool read_rows(int first, int last, SampleType type, void* samples) override {
    if (first != 0 || last != header_.height || !find_picture()) return false;
    std::vector<Rgba> pixels(static_cast<std::size_t>(header_.width) * static_cast<std::size_t>(header_.height));
    if (!read_picture(pixels)) return false;
    const std::span<const std::uint8_t> bytes(pixels.data()->data(), pixels.size() * sizeof(Rgba));
    if (type == SampleType::uint8)
      std::copy(bytes.begin(), bytes.end(), static_cast<std::uint8_t*>(samples));
    else if (type == SampleType::single)
      std::transform(bytes.begin(), bytes.end(), static_cast<float*>(samples),
                     [](std::uint8_t byte) { return static_cast<float>(byte) / 255; });
    else
      return false;
    return true;
  }

  std::string report() override { return std::exchange(report_, std::string()); }

 private:
  bool failed() {
    report_ = message_of(file_->Error);
    return false;
  }

  /// Reads up to the data of the first picture.
  bool find_picture() {
    for (;;) {
      GifRecordType record = UNDEFINED_RECORD_TYPE;
      if (DGifGetRecordType(file_, &record) == GIF_ERROR) return failed();
      if (record == IMAGE_DESC_RECORD_TYPE) {
        return DGifGetImageDesc(file_) == GIF_OK || failed();
      }
      if (record != EXTENSION_RECORD_TYPE) {
        report_ = "no picture";
        return false;
      }
      int code = 0;
      GifByteType* block = nullptr;
      if (DGifGetExtension(file_, &code, &block) == GIF_ERROR) return failed();
      while (block) {
        GraphicsControlBlock control;
        if (code == GRAPHICS_EXT_FUNC_CODE && DGifExtensionToGCB(block[0], block + 1, &control) == GIF_OK)
          transparent_ = control.TransparentColor;
        if (DGifGetExtensionNext(file_, &block) == GIF_ERROR) return failed();
      }
    }
  }

  bool read_picture(std::vector<Rgba>& pixels) {
    const GifImageDesc& place = file_->Image;
    const ColorMapObject* palette = place.ColorMap ? place.ColorMap : file_->SColorMap;
    if (!palette) {
      report_ = "no palette";
      return false;
    }
    std::vector<GifPixelType> row(static_cast<std::size_t>(place.Width));
    for (int i = 0; i < place.Height; ++i) {
      if (DGifGetLine(file_, row.data(), place.Width) == GIF_ERROR) return failed();
      const int y = place.Top + (place.Interlace ? interlaced_row(i, place.Height) : i);
      if (y >= header_.height) continue;
      const int end = std::min(place.Width, header_.width - place.Left);
      for (int x = 0; x < end; ++x) {
        const int value = row[static_cast<std::size_t>(x)];
        if (value == transparent_) continue;
        const GifColorType color = value < palette->ColorCount ? palette->Colors[value] : GifColorType{};
        pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(header_.width) +
               static_cast<std::size_t>(place.Left + x)] = {color.Red, color.Green, color.Blue, 255};
      }
    }
    return true;
  }

  GifFileType* file_;
  int transparent_ = NO_TRANSPARENT_COLOR;
  std::string report_;
};

}  // namespace

std::unique_ptr<ImageReader> open_gif(const char* path, std::string& failure) {
  int error = 0;
  GifFileType* file = DGifOpenFileName(path, &error);
  if (file) return std::make_unique<GifReader>(file);
  failure = message_of(error);
  return nullptr;
}

}  // namespace glowworm
