// Picture files that are damaged, forged or of formats that are not read.
#include <gmock/gmock.h>
#include <zlib.h>

#include <filesystem>

#include "core/memory_budget.h"
#include "image/image_files.h"
#include "image/texture_file.h"

namespace glowworm {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;

class BadImages : public ImageFiles {};

TEST_F(BadImages, WrongFilesAreNamedWithARemedy) {
  write_bytes("text.png", "this is no picture");
  write_bytes("empty.exr", "");
  for (const char* name : {"missing.png", "text.png", "empty.exr", "."}) {
    const std::string message = message_of([&] { read_image(path(name)); });
    EXPECT_THAT(message, HasSubstr(path(name)));
    EXPECT_THAT(message, HasSubstr("\n  ")) << "no remedy";
  }
}

TEST_F(BadImages, TruncatedFilesAreErrors) {
  const Image image = make_image();
  write_exr(path("a.exr"), image);
  write_png(path("a.png"), image);
  std::vector<std::uint8_t> noise(64 * 64 * 3);
  for (std::size_t i = 0; i < noise.size(); ++i)
    noise[i] = static_cast<std::uint8_t>(hash32(static_cast<std::uint32_t>(i)));
  for (const char* name : {"a.jpg", "a.tif", "a.tga", "a.hdr", "a.bmp"}) write_foreign(name, 64, 64, 3, noise);
  for (const char* name : {"a.exr", "a.png", "a.jpg", "a.tif", "a.tga", "a.hdr", "a.bmp"}) {
    const std::string whole = read_bytes(name);
    EXPECT_EQ(message_of([&] { read_image(path(name)); }), "") << name;
    for (const double share : {0.02, 0.3, 0.7}) {
      const std::string cut = std::string("cut-") + name;
      write_bytes(cut, whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
      EXPECT_THAT(message_of([&] { read_image(path(cut)); }), HasSubstr(cut)) << share;
    }
  }
}

TEST_F(BadImages, DamagedFilesNeverCrash) {
  write_exr(path("a.exr"), make_image());
  write_png(path("a.png"), make_image());
  for (const char* name : {"a.exr", "a.png"}) {
    const std::string whole = read_bytes(name);
    int errors = 0;
    for (std::uint32_t trial = 0; trial < 40; ++trial) {
      std::string damaged = whole;
      for (std::uint32_t k = 0; k < 8; ++k) {
        const std::uint32_t h = hash_combine(trial, k);
        damaged[h % (k < 4 ? std::min<std::size_t>(600, whole.size()) : whole.size())] = static_cast<char>(h >> 24);
      }
      write_bytes(std::string("damaged-") + name, damaged);
      if (!message_of([&] { read_image(path(std::string("damaged-") + name)); }).empty()) ++errors;
    }
    EXPECT_GT(errors, 10) << name;
  }
}

/// A BMP of 24 bits, with its pixels or without.
std::string bmp_header(std::int32_t width, std::int32_t height) {
  std::string bytes = "BM";
  const auto add = [&](std::int32_t value, int size) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<char>(value >> (8 * i)));
  };
  for (const std::int32_t value : {54, 0, 54, 40, width, height}) add(value, 4);
  add(1, 2);
  add(24, 2);
  for (const std::int32_t value : {0, 0, 2835, 2835, 0, 0}) add(value, 4);
  return bytes;
}

void add_chunk(std::string& png, const std::string& type, const std::string& data) {
  const auto big_endian = [](std::uint32_t value) {
    std::string out;
    for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<char>(value >> shift));
    return out;
  };
  const std::string body = type + data;
  png += big_endian(static_cast<std::uint32_t>(data.size())) + body;
  png += big_endian(static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

/// A PNG of one bit a pixel with a palette of red and blue, all red.
std::string one_bit_png(std::uint32_t side) {
  std::string header, rows((side / 8 + 1) * std::size_t{side}, '\0');
  for (int i = 0; i < 2; ++i)
    for (int shift = 24; shift >= 0; shift -= 8) header.push_back(static_cast<char>(side >> shift));
  header += std::string("\1\3\0\0\0", 5);
  std::string packed(compressBound(rows.size()), '\0');
  uLongf size = packed.size();
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()), rows.size(),
            9);
  packed.resize(size);
  std::string png = "\x89PNG\r\n\x1a\n";
  add_chunk(png, "IHDR", header);
  add_chunk(png, "PLTE", std::string("\xff\0\0\0\0\xff", 6));
  add_chunk(png, "IDAT", packed);
  add_chunk(png, "IEND", "");
  return png;
}

TEST_F(BadImages, HeadersThatClaimTooMuchOrNothingAreErrors) {
  write_bytes("huge.bmp", bmp_header(200000, 200000));
  EXPECT_THAT(message_of([&] { read_image(path("huge.bmp")); }), HasSubstr("huge.bmp"));
  write_bytes("none.bmp", bmp_header(0, 0));
  EXPECT_THAT(message_of([&] { read_image(path("none.bmp")); }), HasSubstr("none.bmp"));
  EXPECT_THAT(message_of([] { Image(0, 0); }), HasSubstr("0 x 0"));
  EXPECT_THAT(message_of([] { Image(5, -1); }), HasSubstr("5 x -1"));
}

std::string little_endian(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>(value >> (8 * i)));
  return out;
}

/// The beginning of an EXR file: its mark, version with flags, and one attribute of a type that OpenEXR does not know,
/// with the size that it claims.
std::string exr_header(std::uint32_t flags, std::uint32_t claimed) {
  return std::string("\x76\x2f\x31\x01", 4) + little_endian(2 | flags, 4) + std::string("note\0noted", 11) +
         little_endian(claimed, 4);
}

TEST_F(BadImages, AttributesThatClaimMoreThanTheFileTakeNoMemory) {
  write_exr(path("whole.exr"), make_image());
  EXPECT_EQ(message_of([&] { read_image(path("whole.exr")); }), "");
  constexpr std::uint32_t kClaimed = 1'750'000'000;
  const std::string part = exr_header(0x1000, 4) + std::string("abcd\0", 5);
  const std::string files[] = {exr_header(0, kClaimed) + std::string(200, 'x'),
                               exr_header(0x1000, kClaimed) + std::string(200, 'x'),
                               part + exr_header(0, kClaimed).substr(8),  // in the second of many parts
                               // A size below zero, and headers that do not end.
                               exr_header(0, 0x80000000), exr_header(0, 0), part, exr_header(0, 0) + "unended"};
  for (const std::string& bytes : files) {
    write_bytes("forged.exr", bytes);
    restart_peak_resident();
    const std::uint64_t before = peak_resident_bytes();
    EXPECT_THAT(message_of([&] { read_image(path("forged.exr")); }),
                AllOf(HasSubstr("forged.exr"), HasSubstr("cannot be read as EXR")));
    EXPECT_LT(peak_resident_bytes() - before, std::uint64_t{16} << 20);
  }
}

/// OpenEXR's C++ reader returns memory of earlier use as the pixels of some of these; OpenImageIO aborts or divides by
/// zero at others.
TEST_F(BadImages, AForgedExrIsAnErrorThatNamesIt) {
  const std::string folder = std::string(GLOWWORM_SOURCE_DIR) + "/tests/fuzz/corpus/texture/exr/";
  for (const std::string name : {"no_compression.exr", "untyped_compression.exr", "channel_type.exr",
                                 "short_channels.exr", "empty_block.exr", "large_tiles.exr"})
    EXPECT_THAT(message_of([&] { read_image(folder + name); }), HasSubstr(name));
  for (const char* name : {"levels.exr", "parts.exr"}) EXPECT_EQ(message_of([&] { read_image(folder + name); }), "");
}

/// OpenImageIO counts the bytes of a strip in an int, which overflows.
TEST_F(BadImages, ATiffStripOfMoreThanTwoGigabytesIsRefused) {
  const std::string file = std::string(GLOWWORM_SOURCE_DIR) + "/tests/fuzz/corpus/texture/tiff/long_strip.tif";
  EXPECT_THAT(message_of([&] { read_image(file); }), HasSubstr("long_strip.tif"));
}

/// The bytes of a TIFF file of 8-bit YCbCr pixels, all zero, in one strip, which OpenImageIO unpacks at once.
/// @param compression its code; the pixels are written uncompressed
std::string ycbcr_tiff(std::uint32_t width, std::uint32_t height, std::uint16_t compression, std::size_t pixels) {
  constexpr std::uint16_t kShort = 3, kLong = 4;
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count, value;
  };
  constexpr std::uint32_t kEntries = 11, kEnd = 8 + 2 + kEntries * 12 + 4;
  const Entry entries[kEntries] = {{256, kLong, 1, width},
                                   {257, kLong, 1, height},
                                   {258, kShort, 3, kEnd},
                                   {259, kShort, 1, compression},
                                   {262, kShort, 1, 6},        // YCbCr
                                   {273, kLong, 1, kEnd + 6},  // the strip
                                   {277, kShort, 1, 3},        // samples of a pixel
                                   {278, kLong, 1, height},    // rows of a strip
                                   {279, kLong, 1, static_cast<std::uint32_t>(3 * pixels)},
                                   {284, kShort, 1, 1},             // channels interleaved
                                   {530, kShort, 2, 1 | 1 << 16}};  // no subsampling
  std::string file("II*\0\10\0\0\0", 8);
  file += little_endian(kEntries, 2);
  for (const Entry& e : entries)
    file += little_endian(e.tag, 2) + little_endian(e.type, 2) + little_endian(e.count, 4) + little_endian(e.value, 4);
  file += little_endian(0, 4);
  for (int i = 0; i < 3; ++i) file += little_endian(8, 2);
  return file + std::string(3 * pixels, '\0');
}

TEST_F(BadImages, ATiffOfMorePixelsThanItCanHoldIsRefused) {
  const std::string file = std::string(GLOWWORM_SOURCE_DIR) + "/tests/fuzz/corpus/texture/tiff/huge.tif";
  EXPECT_THAT(message_of([&] { read_image(file); }),
              HasSubstr("10264 x 63760 pixels cannot come out of a file of 861"));
  constexpr std::uint16_t kLzma = 34925;  // without a limit of expansion; 70000 x 70000 does not fit into an int
  write_bytes("at-once.tif", ycbcr_tiff(70000, 70000, kLzma, 1));
  EXPECT_THAT(message_of([&] { read_image(path("at-once.tif")); }), HasSubstr("70000 x 70000 pixels"));
}

/// The whole size of such a file is reserved for decoding, even if its texels are written to disk by rows.
TEST_F(BadImages, TiffsThatAreUnpackedAtOnceAreReserved) {
  constexpr std::uint32_t kSide = 1024;
  constexpr std::uint64_t kBudget = std::uint64_t{2} << 20;  // for 3 MiB of pixels
  write_bytes("at-once.tif", ycbcr_tiff(kSide, kSide, 1, kSide * kSide));
  EXPECT_EQ(message_of([&] { read_image(path("at-once.tif")); }), "");
  write_foreign("by-rows.tif", kSide, kSide, 3, std::vector<std::uint8_t>(kSide * kSide * 3));
  const auto open = [&](const char* name) {
    TextureLibrary textures(4, std::make_shared<MemoryBudget>(kBudget));
    return message_of([&] { textures.open(path(name)); });
  };
  EXPECT_EQ(open("by-rows.tif"), "");
  EXPECT_THAT(open("at-once.tif"), HasSubstr("decoding of a texture"));
}

/// A damaged file takes memory only for the rows that it has.
TEST_F(BadImages, RowsThatAFileLacksTakeNoMemory) {
  constexpr int kSide = 4096;
  std::vector<std::uint8_t> noise(kSide * kSide);
  Sampler sampler(SamplerKind::independent, 1, 2, 3);
  for (std::uint8_t& sample : noise) sample = static_cast<std::uint8_t>(256 * sampler.next1());
  write_foreign("whole.png", kSide, kSide, 1, noise);
  write_bytes("cut.png", read_bytes("whole.png").substr(0, kSide * kSide / 16));
  noise = {};
  restart_peak_resident();
  const std::uint64_t before = resident_bytes();
  EXPECT_THAT(message_of([&] { read_image(path("cut.png")); }), HasSubstr("truncated or damaged"));
  EXPECT_LT(peak_resident_bytes() - before, sizeof(float) * kSide * kSide / 4);
}

/// Compressed bytes that unpack to a number of zeros.
std::string packed_zeros(const std::string& compression, std::size_t count) {
  if (compression == "none") return std::string(count, '\0');
  if (compression == "rle") {
    std::string runs;
    for (; count > 0; count -= std::min<std::size_t>(count, 100))
      runs += {static_cast<char>(std::min<std::size_t>(count, 100) - 1), '\0'};
    return runs;
  }
  const std::string zeros(count, '\0');
  std::string packed(compressBound(count), '\0');
  uLongf length = packed.size();
  EXPECT_EQ(
      compress(reinterpret_cast<Bytef*>(packed.data()), &length, reinterpret_cast<const Bytef*>(zeros.data()), count),
      Z_OK);
  packed.resize(length);
  return packed;
}

/// OpenEXR's C++ reader would return memory of earlier use as the pixels that a block lacks.
TEST_F(BadImages, AnExrBlockOfFewerBytesThanItsPixelsIsDamaged) {
  for (const std::string compression : {"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"}) {
    for (const int tile : {0, 64}) {
      // A picture of one block: its place in the file is the last number before it.
      constexpr int kWidth = 50;
      constexpr std::uint64_t kBytes = kWidth * 3 * sizeof(float);
      OIIO::ImageSpec spec(kWidth, 1, 3, OIIO::TypeDesc::FLOAT);
      spec.attribute("compression", compression);
      spec.tile_width = spec.tile_height = tile;
      const std::string name = path("whole.exr");
      const auto output = OIIO::ImageOutput::create(name);
      ASSERT_TRUE(output->open(name, spec));
      const std::vector<float> zeros(tile > 0 ? tile * tile * 3 : kWidth * 3);
      ASSERT_TRUE(tile > 0 ? output->write_tile(0, 0, 0, OIIO::TypeDesc::FLOAT, zeros.data())
                           : output->write_scanline(0, 0, OIIO::TypeDesc::FLOAT, zeros.data()));
      output->close();
      std::string whole = read_bytes("whole.exr");
      std::size_t place = 8;
      while (place < whole.size() && little_endian(place, 8) != whole.substr(place - 8, 8)) ++place;
      ASSERT_LT(place, whole.size());
      const std::string numbers = whole.substr(place, tile > 0 ? 16 : 4);
      const auto with_block = [&](const std::string& block) {
        write_bytes("a.exr", whole.substr(0, place) + numbers + little_endian(block.size(), 4) + block);
        return message_of([&] { read_image(path("a.exr")); });
      };
      const std::string block = whole.substr(place + numbers.size() + 4);
      EXPECT_EQ(with_block(block), "") << compression << tile;
      // Blocks of DWA, and those without compression, are not checked; what they lack is black.
      const bool is_dwa = compression.starts_with("dwa");
      const auto is_refused = [&](const std::string& bytes) {
        const std::string message = with_block(bytes);
        if (message.empty() && (is_dwa || compression == "none")) {
          EXPECT_THAT(read_image(path("a.exr")).rgb(), Each(RGB())) << compression << tile << ' ' << bytes.size();
          return;
        }
        EXPECT_THAT(message, HasSubstr("a.exr: truncated or damaged")) << compression << tile;
      };
      is_refused("");
      if (compression == "none" || compression == "rle" || compression.starts_with("zip")) {
        EXPECT_EQ(with_block(packed_zeros(compression, kBytes)), "") << compression << tile;
        is_refused(packed_zeros(compression, kBytes - 1));
        is_refused(packed_zeros(compression, kBytes + 1));
      }
      // A missing place is found by looking at all blocks.
      whole.replace(place - 8, 8, 8, '\0');
      EXPECT_EQ(with_block(block), "") << compression << tile;
    }
  }
}

TEST_F(BadImages, FilesMayBeAsSmallAsTheirFormatAllows) {
  const std::string png = one_bit_png(1024);
  EXPECT_LT(png.size(), 800u);
  write_bytes("small.png", png);
  const Image image = read_image(path("small.png"));
  EXPECT_EQ(image.width(), 1024);
  EXPECT_EQ(image.rgb()[1024 * 1024 - 1], RGB(1, 0, 0));
  // The same header says too much where a file is shorter than its pixels can be.
  std::string cut = one_bit_png(4096).substr(0, 400);
  write_bytes("cut.png", cut);
  EXPECT_THAT(message_of([&] { read_image(path("cut.png")); }), HasSubstr("cannot come out of a file of 400 bytes"));
}

TEST_F(BadImages, AGifOfMorePixelsThanItCanHoldIsRefused) {
  // 16,952 x 21,381 pixels: 1.4 GB in memory.
  write_bytes("huge.gif", "GIF89a8B\x85Sj" + std::string(40, 'G'));
  EXPECT_THAT(message_of([&] { read_image(path("huge.gif")); }), HasSubstr("16952 x 21381 pixels cannot come out"));
  write_bytes("huge.gif", "GIF89aFRIRRRb");
  EXPECT_THAT(message_of([&] { read_image(path("huge.gif")); }), HasSubstr("21062 x 21065 pixels cannot come out"));
}

TEST_F(BadImages, ABmpOfMorePixelsThanItCanHoldIsRefused) {
  // A run-length encoded picture of 1.9 GB in memory.
  const std::string name = std::string(GLOWWORM_SOURCE_DIR) + "/tests/fuzz/corpus/texture/bmp/huge.bmp";
  EXPECT_THAT(message_of([&] { read_image(name); }), AllOf(HasSubstr("huge.bmp"), HasSubstr("needs more memory")));
}

TEST_F(BadImages, OtherFormatsAreNamedAndNotRead) {
  write_bytes("a.ppm", "P6\n1 1\n255\nabc");
  write_bytes("a.png", "FOR4\0\0\0\x10IMAG");
  write_bytes("b.png", "no picture");
  const std::string read = "PNG, JPEG, EXR, HDR, TIFF, TGA, BMP, WebP and GIF are read";
  EXPECT_THAT(message_of([&] { read_image(path("a.ppm")); }), AllOf(HasSubstr("a PPM picture"), HasSubstr(read)));
  // By what is in them, not by their names.
  EXPECT_THAT(message_of([&] { read_image(path("a.png")); }), AllOf(HasSubstr("an IFF picture"), HasSubstr(read)));
  EXPECT_THAT(message_of([&] { read_image(path("b.png")); }), HasSubstr("not a picture of a format that is read"));
  write_foreign("c.png", 1, 1, 3, {255, 0, 0});
  // Four colours, of which eight bits name more; with 256 colours it is read.
  std::string tga{"\0\1\1\0\0\4\0\x18\0\0\0\0\2\0\1\0\x8\0", 18};
  write_bytes("p.tga", tga + std::string(12, '\x10') + "\xc8\xc8");
  EXPECT_THAT(message_of([&] { read_image(path("p.tga")); }), HasSubstr("palette has fewer colours"));
  tga[5] = 0;
  tga[6] = 1;
  write_bytes("p.tga", tga + std::string(768, '\xff') + "\xc8\xc8");
  EXPECT_EQ(read_image(path("p.tga")).rgb()[1], RGB(1, 1, 1));
  write_bytes("c.tga", read_bytes("c.png"));
  EXPECT_EQ(read_image(path("c.tga")).rgb()[0], RGB(1, 0, 0));
}

}  // namespace
}  // namespace glowworm
