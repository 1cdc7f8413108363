// Writes PNG files by libpng: 8 bits per channel, three channels.
#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "core/atomic_file.h"
#include "core/error.h"
#include "image/color_view.h"
#include "image/image.h"

namespace glowworm {

namespace {

/// Data for libpng's callbacks.
struct Encoding {
  std::string bytes;
  char failure[128] = "out of memory";
};

/// Returns false if memory runs out: libpng does not support exceptions.
bool append(std::string& to, png_bytep bytes, png_size_t count) {
  try {
    to.append(reinterpret_cast<const char*>(bytes), count);
  } catch (const std::exception&) {
    return false;
  }
  return true;
}

void take_bytes(png_structp png, png_bytep bytes, png_size_t count) {
  if (!append(static_cast<Encoding*>(png_get_io_ptr(png))->bytes, bytes, count)) png_error(png, "out of memory");
}

void note_failure(png_structp png, png_const_charp message) {
  Encoding& encoding = *static_cast<Encoding*>(png_get_error_ptr(png));
  std::snprintf(encoding.failure, sizeof encoding.failure, "%s", message);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

/// Encodes rows of 8-bit RGB or RGBA, as sRGB or without saying of what. Returns false if libpng fails. Its longjmp
/// skips no object with a destructor.
bool encode(png_structp png, png_infop info, png_uint_32 width, png_uint_32 height, int color_type, bool srgb,
            png_bytepp rows, std::vector<png_text>& texts) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_IHDR(png, info, width, height, 8, color_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (srgb) png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_text(png, info, texts.data(), static_cast<int>(texts.size()));
  png_set_rows(png, info, rows);
  png_write_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);
  return true;
}

/// Text entries of the header in libpng's form: UTF-8, not compressed. They point into `metadata`.
template <typename Metadata>
std::vector<png_text> texts_of(Metadata& metadata) {
  std::vector<png_text> texts;
  for (auto& [key, value] : metadata) {
    png_text text = {};
    text.compression = PNG_ITXT_COMPRESSION_NONE;
    text.key = const_cast<char*>(key.c_str());
    text.text = const_cast<char*>(value.c_str());
    text.itxt_length = value.size();
    texts.push_back(text);
  }
  return texts;
}

std::vector<std::uint8_t> tone_mapped(const Image& image, ToneCurve curve, float exposure) {
  const std::vector<RGB> pixels = image.rgb();
  std::vector<std::uint8_t> bytes;
  bytes.reserve(pixels.size() * 3);
  for (const RGB& pixel : pixels) {
    const RGB mapped = tone_map(pixel, curve, exposure);
    for (int c = 0; c < 3; ++c) bytes.push_back(to_byte(mapped[c]));
  }
  return bytes;
}

std::string encoded(int width, int height, int channels, bool srgb, std::vector<std::uint8_t> codes,
                    const std::map<std::string, std::string>& metadata) {
  std::vector<png_bytep> rows;
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
    rows.push_back(codes.data() + static_cast<std::size_t>(channels) * static_cast<std::size_t>(width) * y);
  std::vector<png_text> texts = texts_of(metadata);
  Encoding encoding;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &encoding, note_failure, ignore_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (info) png_set_write_fn(png, &encoding, take_bytes, nullptr);
  const int color_type = channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB;
  const bool done = info && encode(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
                                   color_type, srgb, rows.data(), texts);
  png_destroy_write_struct(&png, &info);
  if (!done) throw Error(fmt::format("cannot encode a picture as PNG ({})", encoding.failure));
  return std::move(encoding.bytes);
}

void write_whole(const std::string& path, const std::string& bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

}  // namespace

std::string encode_png(int width, int height, int channels, std::vector<std::uint8_t> codes,
                       const std::map<std::string, std::string>& metadata) {
  return encoded(width, height, channels, true, std::move(codes), metadata);
}

std::string png_bytes(const std::string& path, const Image& image, ToneCurve curve, float exposure) {
  check_not_empty(path, image);
  return encode_png(image.width(), image.height(), 3, tone_mapped(image, curve, exposure), image.metadata);
}

void write_png(const std::string& path, const Image& image, ToneCurve curve, float exposure) {
  write_whole(path, png_bytes(path, image, curve, exposure));
}

void write_png(const std::string& path, const Image& image, const ColorView& view, float exposure) {
  check_not_empty(path, image);
  write_whole(path,
              encoded(image.width(), image.height(), 3, false, shown_by(view, image.rgb(), exposure), image.metadata));
}

}  // namespace glowworm
