// Round trips of picture files.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "image/image_files.h"
#include "image/texture_file.h"

namespace glowworm {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;
using testing::SizeIs;

class ImageIo : public ImageFiles {};

TEST_F(ImageIo, SingleExrKeepsEveryBitOfEveryLayer) {
  const Image image = make_image();
  write_exr(path("a.exr"), image, ExrPrecision::single);
  const Image read = read_image(path("a.exr"));
  ASSERT_EQ(read.width(), kWidth);
  ASSERT_EQ(read.height(), kHeight);
  ASSERT_EQ(read.channels().size(), 10u);
  for (const ImageChannel& channel : image.channels()) {
    EXPECT_THAT(read.channel(channel.name), testing::ElementsAreArray(channel.samples)) << channel.name;
  }
  EXPECT_EQ(read.metadata.at("glowworm:seed"), "42");
  EXPECT_EQ(read.metadata.at("Software"), "glowworm test");
  EXPECT_THAT(names(), testing::ElementsAre("a.exr"));
}

TEST_F(ImageIo, HalfExrKeepsElevenBitsAndDepthWhole) {
  const Image image = make_image();
  write_exr(path("a.exr"), image, ExrPrecision::half);
  const Image read = read_image(path("a.exr"));
  for (const ImageChannel& channel : image.channels()) {
    const std::span<const float> samples = read.channel(channel.name);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const float value = channel.samples[i];
      // Half a unit of the last of 11 bits; of the fixed spacing 2^-24 below the least normal number.
      const float bound = channel.name == "depth.Z" ? 0 : std::max(std::abs(value) * 0x1p-11f, 0x1p-25f);
      ASSERT_LE(std::abs(samples[i] - value), bound) << channel.name << " " << i;
    }
  }
  const auto input = OIIO::ImageInput::open(path("a.exr"));
  ASSERT_TRUE(input);
  const OIIO::ImageSpec& spec = input->spec();
  EXPECT_EQ(spec.channelformat(spec.channelindex("R")), OIIO::TypeDesc::HALF);
  EXPECT_EQ(spec.channelformat(spec.channelindex("depth.Z")), OIIO::TypeDesc::FLOAT);
}

TEST_F(ImageIo, ExrSaysWhereAPartLiesAndHowItWasSeen) {
  Image image = make_image();
  image.place = {100, 50, 640, 360};
  for (std::size_t i = 0; i < 16; ++i) image.matrices["worldToCamera"][i] = static_cast<float>(i);
  image.add_scalar("CryptoObject00.R", std::vector<float>(image.pixel_count(), 1e-30f));
  image.radiance_scale = 2;
  write_exr(path("a.exr"), image);
  const auto input = OIIO::ImageInput::open(path("a.exr"));
  ASSERT_TRUE(input);
  const OIIO::ImageSpec& spec = input->spec();
  EXPECT_EQ(spec.get_float_attribute("whiteLuminance"), 89.5f);  // cd/m^2: 179 lm/W over the scale
  EXPECT_EQ(std::tuple(spec.x, spec.y, spec.width, spec.height), std::tuple(100, 50, kWidth, kHeight));
  EXPECT_EQ(std::tuple(spec.full_x, spec.full_y, spec.full_width, spec.full_height), std::tuple(0, 0, 640, 360));
  float matrix[16] = {}, chromaticities[8] = {};
  ASSERT_TRUE(spec.getattribute("worldtocamera", OIIO::TypeMatrix, matrix));
  EXPECT_EQ(matrix[7], 7);
  ASSERT_TRUE(spec.getattribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), chromaticities));
  EXPECT_FLOAT_EQ(chromaticities[0], 0.64f);  // x of red, Rec. 709
  EXPECT_EQ(spec.channelformat(spec.channelindex("CryptoObject00.R")), OIIO::TypeDesc::FLOAT);
  const Image read = read_image(path("a.exr"));
  EXPECT_EQ(read.place, image.place);
  EXPECT_EQ(read.channel("CryptoObject00.R")[0], 1e-30f);
}

TEST_F(ImageIo, OtherPrimariesAreWarnedOf) {
  write_exr(path("a.exr"), make_image());
  std::string bytes = read_bytes("a.exr");
  const std::size_t attribute = bytes.find(std::string("chromaticities\0chromaticities\0", 30));
  ASSERT_NE(attribute, std::string::npos);
  constexpr float kRedX = 0.708f;  // Rec. 2020
  std::memcpy(bytes.data() + attribute + 30 + 4, &kRedX, sizeof kRedX);
  write_bytes("b.exr", bytes);
  testing::internal::CaptureStderr();
  read_image(path("a.exr"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::Not(HasSubstr("primaries")));
  testing::internal::CaptureStderr();
  read_image(path("b.exr"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("b.exr: its primaries differ from Rec. 709"));
}

TEST_F(ImageIo, PartsAndLayersAreCutOut) {
  const Image whole = make_image();
  const Image part = cut(whole, 5, 4, 9, 10);
  EXPECT_EQ(part.width(), 4);
  EXPECT_EQ(part.channel("G")[4], whole.channel("G")[5 * kWidth + 5]);
  EXPECT_EQ(layer_of(part, "normal").rgb()[0].b, whole.channel("normal.Z")[4 * kWidth + 5]);
  EXPECT_EQ(layer_of(part, "depth").rgb()[0].g, whole.channel("depth.Z")[4 * kWidth + 5]);
  EXPECT_EQ(layer_of(part, "").rgb(), part.rgb());
  try {
    layer_of(part, "direct");
    ADD_FAILURE();
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), HasSubstr("albedo, depth, normal"));
  }
  Image a = part, b = whole;
  a.place.whole_width = kWidth;
  a.place.whole_height = kHeight;
  cut_to_common_part(a, b);
  EXPECT_EQ(a.rgb(), b.rgb());
  EXPECT_THROW(cut(part, 0, 0, 3, 3), std::exception);
}

TEST_F(ImageIo, LayersBeyondTheRangeOfHalvesAreWrittenAsFloats) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const auto& [pixels, fits] :
       std::vector<std::pair<std::vector<RGB>, bool>>{{{{70000, 1.0001f, 0.1f}, {1, 2, 3}}, false},
                                                      {{{1e9f, -1e9f, kInfinity}, {65504, 1, 2}}, false},
                                                      {{{3e-8f, 1e-7f, 0}, {1e-6f, 0, 0}}, false},
                                                      {{{65504, 1, -2}, {0, kInfinity, 0x1p-20f}}, true},
                                                      {{{0, 0, 0}, {0, 0, 0}}, true}}) {
    Image image(2, 1);
    image.add_rgb("", pixels);
    image.add_rgb("albedo", std::vector<RGB>{{0.5f, 1, 0.25f}, {1, 1, 1}});
    write_exr(path("a.exr"), image);
    EXPECT_EQ(read_image(path("a.exr")).rgb(), pixels);
    const auto input = OIIO::ImageInput::open(path("a.exr"));
    ASSERT_TRUE(input);
    const OIIO::ImageSpec& spec = input->spec();
    for (const char* channel : {"R", "G", "B"})
      EXPECT_EQ(spec.channelformat(spec.channelindex(channel)), fits ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT)
          << pixels[0].r;
    EXPECT_EQ(spec.channelformat(spec.channelindex("albedo.R")), OIIO::TypeDesc::HALF);
  }
}

TEST_F(ImageIo, PngIsTheToneMappedPicture) {
  const Image image = make_image();
  for (const ToneCurve curve : {ToneCurve::srgb, ToneCurve::filmic}) {
    write_png(path("a.png"), image, curve, -1);
    const Image read = read_image(path("a.png"));
    EXPECT_EQ(read.metadata.at("glowworm:seed"), "42");
    const std::vector<RGB> linear = image.rgb(), decoded = read.rgb();
    for (std::size_t i = 0; i < linear.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const std::uint8_t code = to_byte(tone_map(linear[i], curve, -1)[c]);
        ASSERT_NEAR(decoded[i][c], srgb_decode(code), 1e-6f);
      }
    }
  }
}

TEST_F(ImageIo, PngOfNonFiniteNumbersIsBlackOrWhite) {
  Image image(3, 1);
  const float nan = std::nanf(""), infinite = std::numeric_limits<float>::infinity();
  image.add_rgb("", std::vector<RGB>{{nan, nan, nan}, {infinite, infinite, infinite}, {-1, -infinite, -0.0f}});
  for (const ToneCurve curve : {ToneCurve::srgb, ToneCurve::filmic}) {
    write_png(path("a.png"), image, curve, 0);
    const std::vector<RGB> read = read_image(path("a.png")).rgb();
    EXPECT_EQ(read[0], RGB(0, 0, 0));
    EXPECT_EQ(read[1], RGB(1, 1, 1));
    EXPECT_EQ(read[2], RGB(0, 0, 0));
  }
}

TEST_F(ImageIo, GreyAndAlphaFilesAreRead) {
  write_foreign("grey.png", 2, 1, 1, {0, 188});
  const std::vector<RGB> grey = read_image(path("grey.png")).rgb();
  EXPECT_EQ(grey[0], RGB(0, 0, 0));
  EXPECT_EQ(grey[1], RGB(srgb_decode(std::uint8_t{188})));

  write_foreign("rgba.tga", 1, 1, 4, {200, 100, 50, 51});
  const Image rgba = read_image(path("rgba.tga"));
  EXPECT_FLOAT_EQ(rgba.channel("A")[0], 0.2f);
}

TEST_F(ImageIo, EndingChoosesTheFormat) {
  const Image image = make_image();
  write_image(path("a.EXR"), image);
  write_image(path("a.png"), image);
  EXPECT_EQ(read_bytes("a.EXR").substr(0, 4), "\x76\x2f\x31\x01");
  EXPECT_EQ(read_bytes("a.png").substr(1, 3), "PNG");
  EXPECT_THAT(message_of([&] { write_image(path("a.gif"), image); }), HasSubstr(".exr"));
  EXPECT_EQ(names().size(), 2u);
}

TEST_F(ImageIo, GifsHaveTheirAlphaLast) {
  // Two pixels: red, and the palette's second colour, which is transparent.
  write_bytes("alpha.gif", std::string("GIF89a\2\0\1\0\x80\0\0\xff\0\0\0\0\xff"
                                       "\x21\xf9\4\1\0\0\1\0"
                                       "\x2c\0\0\0\0\2\0\1\0\0\2\2\x44\x0a\0\x3b",
                                       43));
  const ImageFileHeader header = read_image_header(path("alpha.gif"));
  ASSERT_EQ(header.channels, 4);
  EXPECT_EQ(header.alpha_channel, 3);
  const auto texture = make_texture(read_texels(path("alpha.gif")), {});
  EXPECT_EQ(texture->color({0.25f, 0.5f}), RGB(1, 0, 0));
  EXPECT_EQ(texture->alpha({0.25f, 0.5f}), 1);
  EXPECT_EQ(texture->alpha({0.75f, 0.5f}), 0);
}

/// OpenImageIO looks them up beyond the end of the palette.
TEST_F(ImageIo, PixelsBeyondThePaletteOfAGifAreBlack) {
  // Two white colours and 128 pixels of the values 128 to 255, each a code of nine bits.
  std::string gif("GIF89a\x80\0\1\0\x80\0\0\xff\xff\xff\xff\xff\xff\x2c\0\0\0\0\x80\0\1\0\0\x8", 30);
  constexpr unsigned kClear = 256, kEnd = 257;
  std::string codes;
  unsigned pending = 0, bits = 0;
  const auto append = [&](unsigned code) {
    pending |= code << bits;
    for (bits += 9; bits >= 8; bits -= 8, pending >>= 8) codes += static_cast<char>(pending & 0xff);
  };
  append(kClear);
  for (unsigned value = 128; value < 256; ++value) append(value);
  append(kEnd);
  codes += static_cast<char>(pending);
  write_bytes("beyond.gif", gif + static_cast<char>(codes.size()) + codes + std::string("\0;", 2));
  const std::vector<RGB> pixels = read_image(path("beyond.gif")).rgb();
  EXPECT_THAT(pixels, AllOf(SizeIs(128), Each(RGB(0, 0, 0))));
}

TEST_F(ImageIo, UnwritableOutputLeavesNothing) {
  const Image image = make_image();
  EXPECT_THAT(message_of([&] { write_exr(path("none/a.exr"), image); }), HasSubstr("Create the folder"));
  EXPECT_THAT(message_of([&] { write_png("/dev/full", image); }), HasSubstr("Free space"));
  EXPECT_THAT(message_of([&] { write_png(path("a.png"), Image(2, 2)); }), HasSubstr("no channels"));
  EXPECT_TRUE(names().empty());
}

TEST_F(ImageIo, AFullDiskLeavesNothing) {
  const Image image = make_image();
  rlimit whole{};
  getrlimit(RLIMIT_FSIZE, &whole);
  const rlimit small{1000, whole.rlim_max};
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::vector<std::string> messages;
  for (const char* name : {"a.exr", "a.png"}) messages.push_back(message_of([&] { write_image(path(name), image); }));
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &whole), 0);
  signal(SIGXFSZ, handler);
  EXPECT_THAT(messages, Each(HasSubstr("a.")));
  EXPECT_TRUE(names().empty());
}

TEST_F(ImageIo, SamePictureSameBytes) {
  write_exr(path("a.exr"), make_image());
  write_exr(path("b.exr"), make_image());
  EXPECT_EQ(read_bytes("a.exr"), read_bytes("b.exr"));
}

TEST_F(ImageIo, UnknownChannelIsNamed) {
  EXPECT_THAT(message_of([] { make_image().channel("Q"); }), HasSubstr("albedo.G"));
  EXPECT_THAT(message_of([] { make_image().rgb("caustic"); }), HasSubstr("caustic.R"));
  Image image(2, 2);
  EXPECT_THAT(message_of([&] { image.add_rgb("x", std::vector<RGB>(3)); }), HasSubstr("3 pixels"));
}

}  // namespace
}  // namespace glowworm
