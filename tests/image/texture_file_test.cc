// Texture files: wrapping, filters, colour spaces, and texels in memory against texels in a file.
#include "image/texture_file.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <thread>

#include "core/random.h"
#include "image/texel_store.h"
#include "image/tone_map.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

/// Reads a file into a texture.
std::shared_ptr<const TextureFile> open_texture(const std::string& path, const TextureOptions& options = {}) {
  return make_texture(read_texels(path), options);
}

class TextureFiles : public FolderTest {
 protected:
  template <typename T>
  std::string write(const std::string& name, int width, int height, int channels, OIIO::TypeDesc type,
                    const std::vector<T>& samples) const {
    const auto output = OIIO::ImageOutput::create(name);
    OIIO::ImageSpec spec(width, height, channels, type);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    EXPECT_TRUE(output->open(path(name), spec));
    EXPECT_TRUE(output->write_image(OIIO::BaseTypeFromC<T>::value, samples.data()));
    EXPECT_TRUE(output->close());
    return path(name);
  }
  // A linear grey ramp of 4 x 2 texels: 0 1 2 3 / 4 5 6 7, in floats.
  std::string ramp() const {
    return write<float>("ramp.exr", 4, 2, 1, OIIO::TypeDesc::FLOAT, {0, 1, 2, 3, 4, 5, 6, 7});
  }
  std::string noise(const std::string& name, int width, int height, int channels, OIIO::TypeDesc type) const {
    std::vector<float> samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                               static_cast<std::size_t>(channels));
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = to_unit_float(hash32(static_cast<std::uint32_t>(i)));
    return write<float>(name, width, height, channels, type, samples);
  }
};

TEST_F(TextureFiles, TexelCentresGiveTexels) {
  const auto texture = open_texture(ramp());
  EXPECT_EQ(texture->width(), 4);
  EXPECT_EQ(texture->height(), 2);
  for (int x = 0; x < 4; ++x) {
    const float u = (static_cast<float>(x) + 0.5f) / 4;
    EXPECT_EQ(texture->color({u, 0.75f}), RGB(static_cast<float>(x)));
    EXPECT_EQ(texture->color({u, 0.25f}), RGB(static_cast<float>(x + 4)));
  }
  EXPECT_EQ(texture->color({0.25f, 0.5f}), RGB(2.5f));
}

TEST_F(TextureFiles, Wraps) {
  const std::string file = ramp();
  const auto at = [&](TextureWrap wrap, float u) {
    TextureOptions options;
    options.wrap_u = options.wrap_v = wrap;
    return open_texture(file, options)->color({u, 0.75f}).r;
  };
  EXPECT_FLOAT_EQ(at(TextureWrap::repeat, 0), 1.5f);
  EXPECT_FLOAT_EQ(at(TextureWrap::repeat, -0.125f), 3);
  EXPECT_FLOAT_EQ(at(TextureWrap::repeat, 5.125f), 0);
  EXPECT_FLOAT_EQ(at(TextureWrap::clamp, -7), 0);
  EXPECT_FLOAT_EQ(at(TextureWrap::clamp, 9), 3);
  EXPECT_FLOAT_EQ(at(TextureWrap::mirror, 1.125f), 3);
  EXPECT_FLOAT_EQ(at(TextureWrap::mirror, -0.375f), 1);
  EXPECT_FLOAT_EQ(at(TextureWrap::mirror, 2.125f), 0);
  EXPECT_FLOAT_EQ(at(TextureWrap::black, 1), 1.5f);
  EXPECT_FLOAT_EQ(at(TextureWrap::black, 1.2f), 0);
  EXPECT_FLOAT_EQ(at(TextureWrap::black, -3), 0);
}

TEST_F(TextureFiles, NearestTakesTheTexelUnderThePoint) {
  TextureOptions options;
  options.filter = TextureFilter::nearest;
  for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::clamp, TextureWrap::mirror, TextureWrap::black}) {
    options.wrap_u = options.wrap_v = wrap;
    const auto texture = open_texture(ramp(), options);
    EXPECT_EQ(texture->color({0.26f, 0.9f}), RGB(1));
    EXPECT_EQ(texture->color({0.49f, 0.51f}), RGB(1));
    EXPECT_EQ(texture->color({0.51f, 0.49f}), RGB(6));
  }
}

TEST_F(TextureFiles, ExtremeCoordinatesStayInside) {
  const float infinite = std::numeric_limits<float>::infinity(), huge = std::numeric_limits<float>::max();
  for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::clamp, TextureWrap::mirror, TextureWrap::black}) {
    for (const TextureFilter filter : {TextureFilter::bilinear, TextureFilter::nearest}) {
      TextureOptions options;
      options.wrap_u = options.wrap_v = wrap;
      options.filter = filter;
      const auto texture = open_texture(ramp(), options);
      for (const float t : {std::nanf(""), infinite, -infinite, huge, -huge, -1e-30f, 1.0f, 0.99999994f, -1e7f}) {
        for (const Vec2 uv : {Vec2{t, 0.5f}, Vec2{0.5f, t}, Vec2{t, t}}) {
          const float value = texture->color(uv).r;
          EXPECT_GE(value, 0);
          EXPECT_LE(value, 7);
        }
      }
    }
  }
}

TEST_F(TextureFiles, EncodingsOfEightBits) {
  const std::string file = write<std::uint8_t>("a.png", 1, 1, 3, OIIO::TypeDesc::UINT8, {64, 128, 255});
  TextureOptions options;
  const auto color = [&] { return open_texture(file, options)->color({0.5f, 0.5f}); };
  options.encoding = TextureEncoding::srgb;
  EXPECT_EQ(color(), RGB(srgb_decode(std::uint8_t{64}), srgb_decode(std::uint8_t{128}), 1));
  options.encoding = TextureEncoding::linear;
  EXPECT_EQ(color(), RGB(64 / 255.0f, 128 / 255.0f, 1));
  options.encoding = TextureEncoding::power;
  options.exponent = 2;
  EXPECT_NEAR(color().g, 128 * 128 / 65025.0f, 1e-6f);
  EXPECT_EQ(open_texture(file)->memory_bytes(), 3u);
}

TEST_F(TextureFiles, AutomaticEncodingIsSrgbForIntegersAndLinearForFloats) {
  const std::string bytes = write<std::uint8_t>("a.tga", 1, 1, 3, OIIO::TypeDesc::UINT8, {64, 64, 64});
  EXPECT_EQ(open_texture(bytes)->color({0, 0}), RGB(srgb_decode(std::uint8_t{64})));
  const std::string words = write<std::uint16_t>("a.png", 1, 1, 3, OIIO::TypeDesc::UINT16, {16448, 16448, 16448});
  EXPECT_NEAR(open_texture(words)->color({0, 0}).r, srgb_decode(std::uint8_t{64}), 1e-6f);
  EXPECT_EQ(open_texture(words)->memory_bytes(), 6u);
  const std::string halves = write<float>("a.exr", 1, 1, 3, OIIO::TypeDesc::HALF, {0.25f, 0.5f, 1000});
  EXPECT_EQ(open_texture(halves)->color({0, 0}), RGB(0.25f, 0.5f, 1000));
  EXPECT_EQ(open_texture(halves)->memory_bytes(), 6u);
}

TEST_F(TextureFiles, EveryHalfIsDecodedExactly) {
  // All 65536 codes as one picture, against OpenImageIO's own conversion.
  std::vector<std::uint16_t> codes(65536);
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint16_t>(i);
  std::vector<float> expected(codes.size());
  ASSERT_TRUE(OIIO::convert_pixel_values(OIIO::TypeDesc::HALF, codes.data(), OIIO::TypeDesc::FLOAT, expected.data(),
                                         static_cast<int>(codes.size())));
  auto texels = std::make_shared<ImageFileData>();
  texels->header.width = texels->header.height = 256;
  texels->header.channels = 1;
  texels->header.type = SampleType::half;
  texels->samples.resize(codes.size() * 2);
  std::memcpy(texels->samples.data(), codes.data(), texels->samples.size());
  TextureOptions options;
  options.filter = TextureFilter::nearest;
  const auto texture = make_texture(texels, options);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const Vec2 uv{(static_cast<float>(i % 256) + 0.5f) / 256, 1 - (static_cast<float>(i / 256) + 0.5f) / 256};
    const float value = texture->color(uv).r;
    ASSERT_EQ(value, std::isfinite(expected[i]) ? expected[i] : 0) << i;
  }
}

TEST_F(TextureFiles, AlphaIsKeptApartAndDroppedWhereOpaque) {
  const std::string cut =
      write<std::uint8_t>("cut.png", 2, 1, 4, OIIO::TypeDesc::UINT8, {255, 255, 255, 0, 255, 255, 255, 255});
  const auto texture = open_texture(cut);
  EXPECT_TRUE(texture->has_alpha());
  EXPECT_EQ(texture->color({0.25f, 0.5f}), RGB(1)) << "colour must not be multiplied by alpha";
  EXPECT_EQ(texture->alpha({0.25f, 0.5f}), 0);
  EXPECT_EQ(texture->alpha({0.75f, 0.5f}), 1);
  EXPECT_FLOAT_EQ(texture->alpha({0.5f, 0.5f}), 0.5f);

  const std::string opaque =
      write<std::uint8_t>("opaque.png", 2, 1, 4, OIIO::TypeDesc::UINT8, {1, 2, 3, 255, 4, 5, 6, 255});
  EXPECT_FALSE(open_texture(opaque)->has_alpha());
  EXPECT_EQ(open_texture(opaque)->alpha({0.3f, 0.5f}), 1);
  EXPECT_EQ(open_texture(opaque)->memory_bytes(), 6u);
  EXPECT_EQ(open_texture(opaque)->color({0.75f, 0.5f}).b, srgb_decode(std::uint8_t{6}));

  const std::string grey = write<std::uint8_t>("grey.png", 1, 1, 2, OIIO::TypeDesc::UINT8, {255, 51});
  EXPECT_EQ(open_texture(grey)->color({0, 0}), RGB(1));
  EXPECT_FLOAT_EQ(open_texture(grey)->alpha({0, 0}), 0.2f);
}

TEST_F(TextureFiles, StoredTexelsGiveTheSameBits) {
  const std::vector<std::string> files{
      noise("rgb8.png", 301, 203, 3, OIIO::TypeDesc::UINT8),  noise("rgba8.png", 97, 131, 4, OIIO::TypeDesc::UINT8),
      noise("grey16.png", 65, 64, 1, OIIO::TypeDesc::UINT16), noise("half.exr", 130, 67, 4, OIIO::TypeDesc::HALF),
      noise("photo.jpg", 200, 100, 3, OIIO::TypeDesc::UINT8), noise("sky.hdr", 129, 65, 3, OIIO::TypeDesc::FLOAT)};
  TextureLibrary whole, stored(1);
  for (const std::string& file : files) {
    for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::mirror, TextureWrap::black}) {
      TextureOptions options;
      options.wrap_u = options.wrap_v = wrap;
      const auto a = whole.open(file, options), b = stored.open(file, options);
      ASSERT_EQ(a->width(), b->width());
      for (std::uint32_t i = 0; i < 500; ++i) {
        const Vec2 uv{to_unit_float(hash32(i)) * 4 - 2, to_unit_float(hash32(i + 1000)) * 4 - 2};
        ASSERT_EQ(a->color(uv), b->color(uv)) << file;
        ASSERT_EQ(a->alpha(uv), b->alpha(uv)) << file;
      }
    }
  }
  EXPECT_EQ(whole.stored_files(), 0u);
  EXPECT_EQ(stored.stored_files(), files.size());
  EXPECT_EQ(stored.resident_bytes(), 0u);
}

TEST_F(TextureFiles, AreTheSameObjectWhileInUse) {
  const std::string a = noise("a.png", 10, 10, 3, OIIO::TypeDesc::UINT8);
  const std::string b = noise("b.png", 10, 10, 3, OIIO::TypeDesc::UINT8);
  TextureOptions mirrored;
  mirrored.wrap_u = TextureWrap::mirror;
  for (const std::uint64_t limit : {0u, 1u}) {
    TextureLibrary library(limit);
    const auto of_a = library.open(a), of_b = library.open(b), other = library.open(a, mirrored);
    EXPECT_EQ(library.open(a), of_a);
    EXPECT_EQ(library.find(a, mirrored), other);
    EXPECT_NE(of_a, of_b);
    EXPECT_NE(of_a, other);
  }
}

TEST_F(TextureFiles, LibraryReadsAFileOnceAndKeepsItsLimit) {
  const std::string a = noise("a.png", 100, 100, 3, OIIO::TypeDesc::UINT8);
  const std::string b = noise("b.png", 100, 100, 3, OIIO::TypeDesc::UINT8);
  TextureLibrary library(60000);  // three quarters are 45,000: one file of 30,000 bytes, not two
  const auto first = library.open(a), again = library.open(a);
  EXPECT_EQ(library.resident_bytes(), 30000u);
  EXPECT_EQ(library.stored_files(), 0u);
  const auto second = library.open(b);
  EXPECT_EQ(library.resident_bytes(), 30000u);
  EXPECT_EQ(library.stored_files(), 1u);
  EXPECT_EQ(first->color({0.3f, 0.4f}), second->color({0.3f, 0.4f}));
}

TEST_F(TextureFiles, ATextureOutlivesItsLibrary) {
  const std::string file = noise("a.png", 100, 100, 3, OIIO::TypeDesc::UINT8);
  std::shared_ptr<const TextureFile> stored;
  {
    TextureLibrary library(1);
    stored = library.open(file);
  }
  EXPECT_EQ(stored->color({0.3f, 0.4f}), open_texture(file)->color({0.3f, 0.4f}));
}

TEST_F(TextureFiles, ThreadsMayLookUpAtOnce) {
  const std::string file = noise("a.png", 512, 512, 3, OIIO::TypeDesc::UINT8);
  TextureLibrary library(1);
  const auto stored = library.open(file), whole = open_texture(file);
  std::vector<std::thread> threads;
  std::atomic<int> wrong{0};
  for (std::uint32_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (std::uint32_t i = 0; i < 1000; ++i) {
        const Vec2 uv{to_unit_float(hash32(i * 4 + t)), to_unit_float(hash32(i * 4 + t + 77777))};
        if (!(stored->color(uv) == whole->color(uv))) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(TextureFiles, WrongFilesAreErrors) {
  std::ofstream(path("text.png")) << "no picture";
  TextureLibrary library(1);
  EXPECT_THAT(message_of([&] { open_texture(path("text.png")); }), HasSubstr("text.png"));
  EXPECT_THAT(message_of([&] { library.open(path("text.png")); }), HasSubstr("text.png"));
  EXPECT_THAT(message_of([&] { library.open(path("none.png")); }), HasSubstr("no such file"));
  for (const char* name : {"a.exr", "a.png", "a.jpg", "a.tif"}) {
    const std::string file = noise(name, 256, 256, 3, OIIO::TypeDesc::UINT8);
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    EXPECT_THAT(message_of([&] { open_texture(file); }), HasSubstr("truncated")) << name;
    EXPECT_THAT(message_of([&] { library.open(file); }), HasSubstr("truncated")) << name;
  }
}

TEST_F(TextureFiles, AFileMayChangeOnceItIsOpen) {
  const std::string file = noise("a.exr", 256, 256, 3, OIIO::TypeDesc::HALF);
  TextureLibrary library(1);
  const auto stored = library.open(file), whole = open_texture(file);
  std::filesystem::remove(file);
  for (const Vec2 uv : {Vec2{0.5f, 0.01f}, Vec2{0.5f, 0.99f}}) EXPECT_EQ(stored->color(uv), whole->color(uv));
  EXPECT_EQ(library.open(file)->color({0.5f, 0.5f}), whole->color({0.5f, 0.5f}));
}

TEST_F(TextureFiles, AFileIsFoundByTheNameItWasGiven) {
  const std::string file = noise("a.png", 40, 30, 3, OIIO::TypeDesc::UINT8);
  for (const std::uint64_t limit : {0, 1}) {
    TextureLibrary library(limit);
    EXPECT_EQ(library.find("image 3"), nullptr);
    const auto first = library.open(file, {}, "image 3"), again = library.find("image 3");
    ASSERT_NE(again, nullptr);
    EXPECT_EQ(first->color({0.3f, 0.4f}), again->color({0.3f, 0.4f}));
    EXPECT_EQ(library.find(file), nullptr);
  }
}

TEST_F(TextureFiles, WithoutATemporaryFileTexelsAreHeld) {
  const std::string file = noise("a.png", 100, 100, 3, OIIO::TypeDesc::UINT8);
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", path("nowhere").c_str(), 1);
  TextureLibrary library(1);
  const auto texture = library.open(file);
  before ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
  EXPECT_EQ(library.resident_bytes(), 30000u);
  EXPECT_EQ(library.stored_files(), 0u);
  EXPECT_EQ(texture->color({0.3f, 0.4f}), open_texture(file)->color({0.3f, 0.4f}));
}

TEST_F(TextureFiles, TexelsThatCannotBeReadBackAreMagenta) {
  const std::string file = noise("a.png", 512, 512, 3, OIIO::TypeDesc::UINT8);
  TextureLibrary library(1);
  const auto stored = library.open(file);
  const RGB seen = stored->color({0.5f, 0.01f});
  int cut = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code error;
    const std::string target = std::filesystem::read_symlink(entry.path(), error).string();
    if (!target.ends_with("(deleted)") || !std::filesystem::is_regular_file(entry.path(), error)) continue;
    if (std::filesystem::file_size(entry.path(), error) != 256u * TexelStore::kBlockBytes) continue;
    ASSERT_EQ(truncate(entry.path().c_str(), 0), 0);
    ++cut;
  }
  ASSERT_EQ(cut, 1);
  EXPECT_EQ(stored->color({0.5f, 0.01f}), seen) << "is in the cache";
  EXPECT_EQ(stored->color({0.5f, 0.99f}), RGB(1, 0, 1));
}

TEST_F(TextureFiles, AStoreHoldsNoMoreThanItsCache) {
  EXPECT_EQ(TexelStore(1).cache_bytes(), 8 * TexelStore::kBlockBytes);
  TexelStore store(100 * TexelStore::kBlockBytes);
  EXPECT_EQ(store.cache_bytes(), 96 * TexelStore::kBlockBytes);
  constexpr std::uint32_t kBlocks = 1000;
  std::vector<std::uint32_t> numbers(kBlocks * TexelStore::kBlockBytes / sizeof(std::uint32_t));
  for (std::uint32_t i = 0; i < numbers.size(); ++i) numbers[i] = hash32(i);
  store.write(3, std::as_bytes(std::span(numbers)));
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const std::uint32_t number = hash32(i + 5) % static_cast<std::uint32_t>(numbers.size());
    const std::size_t byte = number * sizeof(std::uint32_t);
    std::uint32_t read = 0;
    store.read(3 + byte / TexelStore::kBlockBytes, byte % TexelStore::kBlockBytes,
               std::as_writable_bytes(std::span(&read, 1)));
    ASSERT_EQ(read, numbers[number]);
  }
}

}  // namespace
}  // namespace glowworm
