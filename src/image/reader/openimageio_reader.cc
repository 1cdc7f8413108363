#include "image/reader/openimageio_reader.h"

#include <OpenImageIO/imageio.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

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
    // Version 2.4 reads beyond the end of damaged ICC profiles.
    if (attribute.type() == OIIO::TypeDesc::STRING && !attribute.name().string().starts_with("ICC"))
      header.metadata[attribute.name().string()] = attribute.get_string();
  }
  if (const float white = spec.get_float_attribute("whiteLuminance"); white > 0)
    header.metadata["whiteLuminance"] = std::to_string(white);
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

class OpenImageIoReader : public ImageReader {
 public:
  explicit OpenImageIoReader(std::unique_ptr<OIIO::ImageInput> input) : input_(std::move(input)) {
    const OIIO::ImageSpec& spec = input_->spec();
    header_ = header_of(spec);
    depth_ = spec.depth;
    tile_height_ = spec.tile_width > 0 ? spec.tile_height : 0;
    unpacks_whole_ = is_tiff_unpacked_whole(spec);
  }

  bool read_rows(int first, int last, SampleType type, void* samples) override {
    const OIIO::ImageSpec& spec = input_->spec();
    const OIIO::TypeDesc format = type_desc(type);
    if (first == 0 && last == spec.height) return input_->read_image(0, 0, 0, spec.nchannels, format, samples);
    if (tile_height_ > 0)
      return input_->read_tiles(0, 0, spec.x, spec.x + spec.width, spec.y + first, spec.y + last, spec.z, spec.z + 1, 0,
                                spec.nchannels, format, samples);
    return input_->read_scanlines(0, 0, spec.y + first, spec.y + last, 0, 0, spec.nchannels, format, samples);
  }

  std::string report() override { return input_->geterror(); }

 private:
  std::unique_ptr<OIIO::ImageInput> input_;
};

/// Opens a file; null, with the reason in `failure`, if that fails.
std::unique_ptr<OIIO::ImageInput> open_input(const std::string& path, const std::string& plugin, bool exr_in_c,
                                             std::string& failure) {
  OIIO::attribute("openexr:core", exr_in_c ? 1 : 0);
  OIIO::ImageSpec config, spec;
  config.attribute("oiio:UnassociatedAlpha", 1);
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(plugin);
  if (input && input->open(path, spec, config)) return input;
  failure = input ? input->geterror() : OIIO::geterror();
  return nullptr;
}

}  // namespace

std::unique_ptr<ImageReader> open_by_openimageio(const std::string& path, const std::string& plugin,
                                                 std::string& failure) {
  // Pictures are decoded by this thread.
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", -1);
  // OpenEXR's library in C (3.1) finds damaged blocks that the one in C++ returns as memory of earlier use, but lacks
  // DWA, and does not check blocks without compression. For these, malloc() returns zeros (it inverts the value; the
  // parent has switched its cache off), so that a file gives the same pixels each time.
  std::unique_ptr<OIIO::ImageInput> input = open_input(path, plugin, true, failure);
  const std::string compression = input ? input->spec().get_string_attribute("compression") : "";
  const bool is_dwa = compression.starts_with("dwa");
  mallopt(M_PERTURB, plugin == "openexr" && (is_dwa || compression == "none") ? 0xff : 0);
  if (is_dwa) input = open_input(path, plugin, false, failure);
  if (input && input->spec().deep) {
    failure = "a deep picture";
    return nullptr;
  }
  return input ? std::make_unique<OpenImageIoReader>(std::move(input)) : nullptr;
}

}  // namespace glowworm
