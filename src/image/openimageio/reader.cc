// The shared library of image/image_reader.h: the one place where pixels come out of OpenImageIO.
#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iterator>
#include <limits>
#include <mutex>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "image/image_reader.h"
#include "image/openimageio/gif_reader.h"

namespace glowworm {
namespace {

SampleType sample_type(const OIIO::ImageSpec& spec) {
  switch (spec.format.basetype) {
    case OIIO::TypeDesc::UINT8:
      return SampleType::uint8;
    case OIIO::TypeDesc::UINT16:
      return SampleType::uint16;
    case OIIO::TypeDesc::HALF:
      return SampleType::half;
    default:
      return SampleType::single;
  }
}

OIIO::TypeDesc type_desc(SampleType type) {
  switch (type) {
    case SampleType::uint8:
      return OIIO::TypeDesc::UINT8;
    case SampleType::uint16:
      return OIIO::TypeDesc::UINT16;
    case SampleType::half:
      return OIIO::TypeDesc::HALF;
    case SampleType::single:
      break;
  }
  return OIIO::TypeDesc::FLOAT;
}

TransferFunction transfer_function(const OIIO::ImageSpec& spec) {
  using Kind = TransferFunction::Kind;
  const std::string space = spec.get_string_attribute("oiio:ColorSpace");
  const float gamma = spec.get_float_attribute("oiio:Gamma", 1.0f);
  if (space.starts_with("Gamma") || space.starts_with("gamma")) {
    return gamma > 0 && gamma != 1 ? TransferFunction{Kind::power, gamma} : TransferFunction{};
  }
  if (space == "sRGB") return {Kind::srgb, 1};
  if (space.empty() && !spec.format.is_floating_point()) return {Kind::srgb, 1};
  return {};
}

/// Whether a file of colours has the attribute of EXR files that tells its primaries and white, and they are not those
/// of Rec. 709.
bool has_other_primaries(const OIIO::ImageSpec& spec) {
  constexpr float kRec709[8] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
  constexpr float kRounding = 0.002f;
  float given[8] = {};
  if (spec.nchannels < 3 || !spec.getattribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), given))
    return false;
  return !std::equal(std::begin(given), std::end(given), std::begin(kRec709),
                     [](float a, float b) { return std::abs(a - b) <= kRounding; });
}

ImageFileHeader header_of(const OIIO::ImageSpec& spec) {
  ImageFileHeader header;
  header.width = spec.width;
  header.height = spec.height;
  if (spec.full_x == 0 && spec.full_y == 0 && (spec.full_width != spec.width || spec.full_height != spec.height)) {
    header.x0 = spec.x;
    header.y0 = spec.y;
    header.whole_width = spec.full_width;
    header.whole_height = spec.full_height;
  }
  header.channels = spec.nchannels;
  header.alpha_channel = spec.alpha_channel < spec.nchannels ? spec.alpha_channel : -1;
  header.type = sample_type(spec);
  header.transfer = transfer_function(spec);
  header.other_primaries = has_other_primaries(spec);
  header.channel_names = spec.channelnames;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    if (attribute.type() == OIIO::TypeDesc::STRING) header.metadata[attribute.name().string()] = attribute.get_string();
  }
  return header;
}

/// Whether OpenImageIO (2.4) reads a TIFF file by TIFFReadRGBAImageOriented(), all pixels at once.
bool is_tiff_unpacked_whole(const OIIO::ImageSpec& spec) {
  constexpr std::string_view kSpaces[] = {"YCbCr", "CIELAB", "ICCLAB", "ITULAB", "LOGL", "LOGLUV"};
  constexpr int kOldJpeg = 6, kJpeg = 7;
  const int compression = spec.get_int_attribute("tiff:Compression");
  const std::string_view space = spec.get_string_attribute("tiff:ColorSpace");
  return ((compression == kOldJpeg || compression == kJpeg) && spec.nchannels != 3) ||
         std::find(std::begin(kSpaces), std::end(kSpaces), space) != std::end(kSpaces);
}

/// Why a file cannot be read although it was opened; empty if it can. OpenImageIO (2.4) counts the pixels that it
/// unpacks at once and the bytes of a strip in an int.
std::string reason_not_to_read(const OIIO::ImageSpec& spec) {
  constexpr std::uint64_t kMost = std::numeric_limits<int>::max();
  if (spec.image_pixels() > kMost && is_tiff_unpacked_whole(spec))
    return "it claims " + std::to_string(spec.image_pixels()) + " pixels, all of which would be unpacked at once";
  const auto strip = static_cast<std::uint64_t>(std::max(spec.get_int_attribute("tiff:RowsPerStrip"), 0));
  if (const std::uint64_t bytes = spec.scanline_bytes(true) * strip; bytes > kMost)
    return "it claims a strip of " + std::to_string(bytes) + " bytes";
  return "";
}

/// Whether memory was refused within OpenImageIO (2.4), which then may have left a lock of its table of strings held:
/// the next to take it would wait forever, and the destructor of the table would abort the process.
std::atomic<bool> is_spoilt = false;
constexpr const char* kSpoilt = "no memory was left while an image was read";

/// To be called where an allocation has failed: no image is read any more, and the process ends without destructors.
void spoil() {
  if (!is_spoilt.exchange(true))
    on_exit(
        [](int status, void*) {
          std::fflush(nullptr);
          _exit(status);
        },
        nullptr);
}

class OpenImageIoReader : public ImageReader {
 public:
  explicit OpenImageIoReader(std::unique_ptr<OIIO::ImageInput> input) : input_(std::move(input)) {
    const OIIO::ImageSpec& spec = input_->spec();
    header_ = header_of(spec);
    depth_ = spec.depth;
    tile_height_ = spec.tile_width > 0 ? spec.tile_height : 0;
    unpacks_whole_ = is_tiff_unpacked_whole(spec);
  }

  bool read_rows(int first, int last, SampleType type, void* samples) override try {
    if (is_spoilt) {
      exception_ = kSpoilt;
      return false;
    }
    const OIIO::ImageSpec& spec = input_->spec();
    const OIIO::TypeDesc format = type_desc(type);
    if (first == 0 && last == spec.height) return input_->read_image(0, 0, 0, spec.nchannels, format, samples);
    if (tile_height_ > 0)
      return input_->read_tiles(0, 0, spec.x, spec.x + spec.width, spec.y + first, spec.y + last, spec.z, spec.z + 1, 0,
                                spec.nchannels, format, samples);
    return input_->read_scanlines(0, 0, spec.y + first, spec.y + last, 0, 0, spec.nchannels, format, samples);
  } catch (const std::bad_alloc&) {
    spoil();
    exception_ = kSpoilt;
    return false;
  } catch (const std::exception& e) {
    exception_ = e.what();
    return false;
  }

  std::string report() override {
    return exception_.empty() ? input_->geterror() : std::exchange(exception_, std::string());
  }

 private:
  std::unique_ptr<OIIO::ImageInput> input_;
  std::string exception_;  // with which the last reading ended
};

/// Fixes OpenImageIO's own threads at none: pictures are decoded by the thread that asks.
void configure_openimageio() {
  static std::once_flag once;
  std::call_once(once, [] {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
  });
}

}  // namespace
}  // namespace glowworm

OIIO_NAMESPACE_BEGIN
/// Takes the place of OpenImageIO's function of this name, which reads beyond the end of damaged profiles (2.4).
/// Nothing here uses ICC profiles. The dynamic linker looks in this library before OpenImageIO. Declared as in its
/// tiffutils.h, which needs headers of libtiff.
OIIO_API bool decode_icc_profile(cspan<uint8_t> iccdata, ImageSpec& spec, std::string& error);
bool decode_icc_profile(cspan<uint8_t> /*iccdata*/, ImageSpec& /*spec*/, std::string& /*error*/) { return true; }
OIIO_NAMESPACE_END

extern "C" glowworm::ImageReader* glowworm_open_image(const char* path, const char* plugin, std::string& failure) try {
  if (plugin == std::string_view("gif")) return glowworm::open_gif(path, failure).release();
  if (glowworm::is_spoilt) {
    failure = glowworm::kSpoilt;
    return nullptr;
  }
  glowworm::configure_openimageio();
  OIIO::ImageSpec config, spec;
  config.attribute("oiio:UnassociatedAlpha", 1);
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(plugin);
  if (!input) {
    failure = OIIO::geterror();
    return nullptr;
  }
  if (!input->open(path, spec, config)) {
    failure = input->geterror();
    return nullptr;
  }
  failure = glowworm::reason_not_to_read(spec);
  if (!failure.empty()) return nullptr;
  return new glowworm::OpenImageIoReader(std::move(input));
} catch (const std::bad_alloc&) {
  glowworm::spoil();
  failure = glowworm::kSpoilt;
  return nullptr;
} catch (const std::exception& e) {
  failure = e.what();
  return nullptr;
}
