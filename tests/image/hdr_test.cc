// Radiance pictures as other programs write them.
#include <gmock/gmock.h>

#include <cmath>

#include "core/error.h"
#include "image/image.h"
#include "image/texture_file.h"
#include "image_files.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

using Pixel = std::array<std::uint8_t, 4>;

std::string bytes_of(const std::vector<Pixel>& pixels) {
  std::string out;
  for (const Pixel& p : pixels) out.append(reinterpret_cast<const char*>(p.data()), p.size());
  return out;
}

class HdrTest : public ImageFiles {
 protected:
  Image read(const std::string& header, const std::string& pixels) const {
    write_bytes("a.hdr", "#?RADIANCE\n" + header + pixels);
    return read_image(path("a.hdr"));
  }
  std::string refusal(const std::string& header, const std::string& pixels) const {
    try {
      read(header, pixels);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  }
  static std::vector<float> red(const Image& image) { return {image.channel("R").begin(), image.channel("R").end()}; }
};

constexpr Pixel kOne{128, 128, 128, 129};  // 128 / 256 * 2

TEST_F(HdrTest, ExposureAndColourCorrectionAreTakenOut) {
  const std::string size = "\n-Y 1 +X 1\n", one = bytes_of({kOne});
  EXPECT_EQ(read(size, one).channel("R")[0], 1) << "without FORMAT";
  EXPECT_EQ(read("FORMAT=32-bit_rle_rgbe\nEXPOSURE=4\n" + size, one).channel("R")[0], 0.25f);
  const Image image = read("rpict -x 1\nEXPOSURE= 4\nCOLORCORR=1 2 4\nEXPOSURE=0.5\n" + size, one);
  EXPECT_EQ(image.channel("R")[0], 0.5f);
  EXPECT_EQ(image.channel("G")[0], 0.25f);
  EXPECT_EQ(image.channel("B")[0], 0.125f);
}

TEST_F(HdrTest, XyzBecomesLinearRgb) {
  // D65 white of luminance 1, in 128ths, rounded.
  const Image image = read("FORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", bytes_of({{122, 128, 139, 129}}));
  for (const char* channel : {"R", "G", "B"}) EXPECT_NEAR(image.channel(channel)[0], 1, 0.015f) << channel;
}

TEST_F(HdrTest, RowsAndColumnsInAllOrders) {
  // Two columns and three rows, as numbered from the top left.
  struct Order {
    const char* resolution;
    std::vector<std::uint8_t> numbers;
  };
  const Order orders[] = {{"-Y 3 +X 2", {0, 1, 2, 3, 4, 5}}, {"-Y 3 -X 2", {1, 0, 3, 2, 5, 4}},
                          {"+Y 3 +X 2", {4, 5, 2, 3, 0, 1}}, {"+Y 3 -X 2", {5, 4, 3, 2, 1, 0}},
                          {"+X 2 -Y 3", {0, 2, 4, 1, 3, 5}}, {"-X 2 -Y 3", {1, 3, 5, 0, 2, 4}},
                          {"+X 2 +Y 3", {4, 2, 0, 5, 3, 1}}, {"-X 2 +Y 3", {5, 3, 1, 4, 2, 0}}};
  for (const Order& order : orders) {
    std::vector<Pixel> pixels;
    for (const std::uint8_t number : order.numbers) pixels.push_back({number, 0, 0, 136});
    const Image image = read(std::string("\n") + order.resolution + "\n", bytes_of(pixels));
    EXPECT_EQ(image.width(), 2);
    EXPECT_EQ(red(image), (std::vector<float>{0, 1, 2, 3, 4, 5})) << order.resolution;
  }
}

TEST_F(HdrTest, RunLengthsOfBothKinds) {
  const std::vector<float> eight(8, 1.0f);
  std::string packed = {2, 2, 0, 8};
  for (const char byte : {'\x80', '\x80', '\x80'}) packed += std::string{'\x88', byte};  // eight times
  packed += std::string{'\x07'} + std::string(7, '\x81') + std::string{'\x81', '\x81'};
  EXPECT_EQ(red(read("\n-Y 1 +X 8\n", packed)), eight);
  EXPECT_EQ(red(read("\n-Y 1 +X 8\n", bytes_of({kOne, {1, 1, 1, 6}, kOne}))), eight);
  // Repeated counts have digits of 256.
  EXPECT_EQ(red(read("\n-Y 1 +X 300\n", bytes_of({kOne, {1, 1, 1, 43}, {1, 1, 1, 1}}))), std::vector<float>(300, 1.0f));
}

TEST_F(HdrTest, BandsOfRowsGiveTheWholePicture) {
  std::vector<Pixel> pixels;
  for (int i = 0; i < 200 * 4; ++i) pixels.push_back({static_cast<std::uint8_t>(2 + i % 200), 0, 7, 136});
  write_bytes("a.hdr", "#?RGBE\n\n-Y 200 +X 4\n" + bytes_of(pixels));
  TextureLibrary library;
  const auto texture = library.open(path("a.hdr"), {});
  EXPECT_NEAR(texture->color({0.125f, 1 - 0.5f / 200}).r, 2, 1e-3f);
  EXPECT_NEAR(texture->color({0.875f, 0.5f / 200}).r, 2 + 799 % 200, 0.1f);
}

TEST_F(HdrTest, WrittenPicturesReadBack) {
  for (const int width : {3, 8, 300}) {
    Image image(width, 3);
    std::vector<RGB> pixels;
    for (int i = 0; i < 3 * width; ++i) {
      const float level = i % 50 < 20 ? 3.0f : std::ldexp(1.0f + static_cast<float>(i % 7) / 8, i % 40 - 20);
      pixels.push_back(RGB(level, level / 2, 0));
    }
    pixels[1] = RGB(-1, 1e-39f, 0);
    image.add_rgb("", pixels);
    image.radiance_scale = 4;
    image.metadata[kRadianceView] = "-vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180";
    write_hdr(path("out.hdr"), image);
    const Image read = read_image(path("out.hdr"));
    EXPECT_EQ(read.metadata.at(kRadianceView), " " + image.metadata.at(kRadianceView));
    EXPECT_EQ(read.rgb()[1].g, 0);
    for (std::size_t i = 2; i < pixels.size(); ++i) {
      // Mantissas are cut to eight bits; the exposure is taken out.
      ASSERT_LE(std::abs(read.rgb()[i].r * 4 - pixels[i].r), pixels[i].r / 128) << width << ' ' << i;
      ASSERT_EQ(read.rgb()[i].b, 0);
    }
  }
}

TEST_F(HdrTest, BadHeadersAndPixelsAreRefused) {
  const std::string one = bytes_of({kOne});
  EXPECT_THAT(refusal("FORMAT=other\n\n-Y 1 +X 1\n", one), HasSubstr("its FORMAT is neither"));
  EXPECT_THAT(refusal("EXPOSURE=0\n\n-Y 1 +X 1\n", one), HasSubstr("EXPOSURE holds no positive number"));
  for (const char* size : {"-Y 1 +Y 1", "Y 1 X 1", "-Y 0 +X 1", "-Y 1", "-Y 1.5 +X 1", "-Y 9999999999 +X 1", "nothing"})
    EXPECT_THAT(refusal(std::string("\n") + size + "\n", one), HasSubstr("resolution")) << size;
  EXPECT_THAT(refusal("", ""), HasSubstr("no end"));
  EXPECT_THAT(refusal("\n-Y 1 +X 2\n", one), HasSubstr("ends within its pixels"));
  EXPECT_THAT(refusal("\n+X 2 -Y 1\n", one), HasSubstr("ends within its pixels"));
  EXPECT_THAT(refusal("\n-Y 1 +X 2\n", bytes_of({{1, 1, 1, 2}})), HasSubstr("longer than its scanline"));
  EXPECT_THAT(refusal("\n-Y 1 +X 3\n", bytes_of({kOne, {1, 1, 1, 9}})), HasSubstr("longer than its scanline"));
  EXPECT_THAT(refusal("\n-Y 1 +X 8\n", std::string{2, 2, 0, 9} + "xxxxxxxx"), HasSubstr("another length"));
  EXPECT_THAT(refusal("\n-Y 1 +X 8\n", std::string{2, 2, 0, 8, 0} + "xxxxxxxx"), HasSubstr("longer than its scanline"));
}

}  // namespace
}  // namespace glowworm
