#include "image/hdr_reader.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <utility>
#include <vector>

#include "core/lines.h"
#include "core/rgb.h"
#include "image/image.h"

namespace glowworm {

namespace {

constexpr std::size_t kMostHeaderBytes = std::size_t{1} << 20;
constexpr const char* kCutOff = "the file ends within its pixels";
using Rgbe = std::array<std::uint8_t, 4>;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// One axis of a picture in the order of the file.
struct Axis {
  int length = 0;
  bool is_x = false, reversed = false;  ///< reversed: from the right, or from the bottom

  int place(int i) const { return reversed ? length - 1 - i : i; }
};

struct HdrHeader {
  Axis lines, pixels;  ///< scanlines, and pixels of a scanline
  bool xyz = false, other_primaries = false;
  float gamma = 1;
  double scale[3] = {1, 1, 1};  ///< factors on the file's numbers
  std::string view;             ///< of the VIEW lines, the last of which count
};

/// Reads numbers with blanks between them. Returns whether there are `count` and no more.
bool read_numbers(std::string_view text, double* values, int count) {
  const auto skip_blanks = [&] { text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size())); };
  skip_blanks();
  for (int i = 0; i < count; ++i) {
    if (!take_number(text, values[i])) return false;
    skip_blanks();
  }
  return text.empty();
}

/// A line of the header, "NAME=VALUE".
class HeaderParser {
 public:
  explicit HeaderParser(HdrHeader& header) : header_(header) {}

  /// Returns why the file cannot be read, or "".
  std::string take(std::string_view line) {
    const std::size_t equals = line.find('=');
    if (line.starts_with('#') || equals == std::string_view::npos) return "";
    const std::string_view key = line.substr(0, equals), value = line.substr(equals + 1);
    if (key == "VIEW") header_.view += std::string(value);
    if (key == "FORMAT") return set_format(value);
    if (key == "EXPOSURE") return set_scale(key, value, 1);
    if (key == "COLORCORR") return set_scale(key, value, 3);
    if (key == "PRIMARIES") return set_primaries(value);
    if (double gamma = 1; key == "GAMMA" && read_numbers(value, &gamma, 1) && gamma > 0)
      header_.gamma = static_cast<float>(gamma);
    return "";
  }

 private:
  std::string set_format(std::string_view value) {
    value = trimmed(value);
    header_.xyz = value == "32-bit_rle_xyze";
    const bool known = header_.xyz || value == "32-bit_rle_rgbe";
    return known ? "" : "its FORMAT is neither 32-bit_rle_rgbe nor 32-bit_rle_xyze";
  }

  /// Several lines of one name multiply.
  std::string set_scale(std::string_view key, std::string_view value, int count) {
    double given[3] = {1, 1, 1};
    const bool numbers = read_numbers(value, given, count);
    for (int c = 0; c < 3; ++c) {
      const double divisor = given[count == 1 ? 0 : c];
      if (!numbers || !(divisor > 0 && std::isfinite(divisor))) return std::string(key) + " holds no positive number";
      header_.scale[c] /= divisor;
    }
    return "";
  }

  std::string set_primaries(std::string_view value) {
    constexpr double kRec709[8] = {0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329}, kRounding = 0.002;
    double given[8] = {};
    if (!read_numbers(value, given, 8)) return "PRIMARIES does not hold eight numbers";
    for (int i = 0; i < 8; ++i)
      header_.other_primaries = header_.other_primaries || std::abs(given[i] - kRec709[i]) > kRounding;
    return "";
  }

  HdrHeader& header_;
};

/// Reads "-Y", "+X" or the like, and a length.
bool take_axis(std::string_view& text, Axis& axis) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  if (text.size() < 3 || (text[0] != '-' && text[0] != '+') || (text[1] != 'X' && text[1] != 'Y')) return false;
  axis.is_x = text[1] == 'X';
  axis.reversed = (text[0] == '-') == axis.is_x;  // y counts upwards
  text.remove_prefix(2);
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  double length = 0;
  if (!take_number(text, length) || !(length >= 1 && length <= 1 << 30) || length != std::floor(length)) return false;
  axis.length = static_cast<int>(length);
  return true;
}

/// The next line, without its end; false at the end of the file.
bool read_line(std::FILE* file, std::size_t& room, std::string& line) {
  line.clear();
  for (int c = std::getc(file); c != '\n'; c = std::getc(file)) {
    if (c == EOF || room == 0) return false;
    --room;
    line.push_back(static_cast<char>(c));
  }
  if (line.ends_with('\r')) line.pop_back();
  return true;
}

/// Returns why the file cannot be read, or "".
std::string read_header(std::FILE* file, HdrHeader& header) {
  constexpr const char* kNoEnd = "its header has no end";
  std::size_t room = kMostHeaderBytes;
  std::string line;
  HeaderParser parser(header);
  for (;;) {
    if (!read_line(file, room, line)) return kNoEnd;
    if (line.empty()) break;
    if (const std::string problem = parser.take(line); !problem.empty()) return problem;
  }
  if (!read_line(file, room, line)) return kNoEnd;
  std::string_view rest = line;
  const bool axes = take_axis(rest, header.lines) && take_axis(rest, header.pixels);
  if (!axes || header.lines.is_x == header.pixels.is_x) return "its resolution is not like '-Y 512 +X 1024'";
  return "";
}

class HdrReader final : public ImageReader {
 public:
  HdrReader(File file, const HdrHeader& header) : file_(std::move(file)), hdr_(header) {
    begin_ = std::ftell(file_.get());
    header_.width = (hdr_.lines.is_x ? hdr_.lines : hdr_.pixels).length;
    header_.height = (hdr_.lines.is_x ? hdr_.pixels : hdr_.lines).length;
    header_.channels = 3;
    header_.channel_names = {"R", "G", "B"};
    if (!hdr_.view.empty()) header_.metadata[kRadianceView] = hdr_.view;
    header_.other_primaries = hdr_.other_primaries && !hdr_.xyz;
    if (hdr_.gamma != 1) header_.transfer = {TransferFunction::Kind::power, hdr_.gamma};
    depth_ = 1;
    unpacks_whole_ = hdr_.lines.is_x || hdr_.lines.reversed;
    for (int e = 1; e < 256; ++e) power_[static_cast<std::size_t>(e)] = std::ldexp(1.0, e - 136);
  }

  bool read_rows(int first, int last, SampleType type, void* samples) override {
    if (type != SampleType::single) return false;
    auto* out = static_cast<float*>(samples);
    if (unpacks_whole_) {
      if (first != 0 || last != header_.height || !move_to(0)) return false;
      return read_lines(hdr_.lines.length, out);
    }
    return move_to(first) && read_lines(last - first, out);
  }

  std::string report() override { return std::exchange(report_, std::string()); }

 private:
  bool failed(const char* why) {
    report_ = why;
    return false;
  }

  /// Goes on at a scanline of the file.
  bool move_to(int line) {
    if (line < next_line_) {
      if (std::fseek(file_.get(), begin_, SEEK_SET) != 0) return failed("the file cannot be read again");
      next_line_ = 0;
    }
    while (next_line_ < line)
      if (!read_scanline()) return false;
    return true;
  }

  /// Reads scanlines to their places in `out`, which holds them alone.
  bool read_lines(int count, float* out) {
    const auto width = static_cast<std::size_t>(header_.width);
    for (int line = 0; line < count; ++line) {
      if (!read_scanline()) return false;
      for (int i = 0; i < hdr_.pixels.length; ++i) {
        const int along = hdr_.pixels.place(i), across = unpacks_whole_ ? hdr_.lines.place(line) : line;
        const int x = hdr_.lines.is_x ? across : along, y = hdr_.lines.is_x ? along : across;
        const RGB color = color_of(pixels_[static_cast<std::size_t>(i)]);
        float* to = out + 3 * (static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x));
        to[0] = color.r, to[1] = color.g, to[2] = color.b;
      }
    }
    return true;
  }

  RGB color_of(const Rgbe& pixel) const {
    double c[3];
    for (std::size_t i = 0; i < 3; ++i) c[i] = pixel[i] * power_[pixel[3]] * hdr_.scale[i];
    if (hdr_.xyz) {
      // The inverse of the matrix of Rec. 709 primaries and D65 (IEC 61966-2-1).
      const double x = c[0], y = c[1], z = c[2];
      c[0] = 3.2404542 * x - 1.5371385 * y - 0.4985314 * z;
      c[1] = -0.9692660 * x + 1.8760108 * y + 0.0415560 * z;
      c[2] = 0.0556434 * x - 0.2040259 * y + 1.0572252 * z;
    }
    return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
  }

  bool read_scanline() {
    constexpr int kFewestPacked = 8, kMostPacked = 0x7fff;
    const int length = hdr_.pixels.length;
    pixels_.resize(static_cast<std::size_t>(length));
    Rgbe first;
    if (!read_pixel(first)) return failed(kCutOff);
    ++next_line_;
    const bool packed =
        length >= kFewestPacked && length <= kMostPacked && first[0] == 2 && first[1] == 2 && first[2] < 128;
    if (!packed) return read_flat(first);
    if ((first[2] << 8 | first[3]) != length) return failed("a scanline has another length than the picture");
    for (std::size_t channel = 0; channel < 4; ++channel)
      if (!read_channel(channel)) return false;
    return true;
  }

  /// Reads the run lengths of one channel: a byte above 128 counts copies of the next byte, another counts bytes.
  bool read_channel(std::size_t channel) {
    for (std::size_t at = 0; at < pixels_.size();) {
      const int code = std::getc(file_.get());
      if (code == EOF) return failed(kCutOff);
      const auto count = static_cast<std::size_t>(code > 128 ? code - 128 : code);
      if (count == 0 || count > pixels_.size() - at) return failed("a run is longer than its scanline");
      int byte = code > 128 ? std::getc(file_.get()) : 0;
      for (std::size_t i = 0; i < count; ++i) {
        if (code <= 128) byte = std::getc(file_.get());
        if (byte == EOF) return failed(kCutOff);
        pixels_[at++][channel] = static_cast<std::uint8_t>(byte);
      }
    }
    return true;
  }

  /// Reads pixels one by one. (1, 1, 1, n) repeats the pixel before n times; the next of these in a row counts 256 n.
  bool read_flat(Rgbe pixel) {
    int shift = 0;
    for (std::size_t at = 0; at < pixels_.size();) {
      if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
        const std::size_t count = shift <= 24 ? std::size_t{pixel[3]} << shift : pixels_.size() + 1;
        if (at == 0 || count > pixels_.size() - at) return failed("a run is longer than its scanline");
        for (std::size_t i = 0; i < count; ++i, ++at) pixels_[at] = pixels_[at - 1];
        shift += 8;
      } else {
        pixels_[at++] = pixel;
        shift = 0;
      }
      if (at < pixels_.size() && !read_pixel(pixel)) return failed(kCutOff);
    }
    return true;
  }

  bool read_pixel(Rgbe& pixel) { return std::fread(pixel.data(), 1, pixel.size(), file_.get()) == pixel.size(); }

  File file_;
  HdrHeader hdr_;
  long begin_ = 0;                   ///< of the pixels
  int next_line_ = 0;                ///< of the file
  std::array<double, 256> power_{};  ///< the value of one in a mantissa, by exponent
  std::vector<Rgbe> pixels_;         ///< of the last scanline
  std::string report_;
};

}  // namespace

std::unique_ptr<ImageReader> open_hdr(const std::string& path, std::string& failure) {
  File file(std::fopen(path.c_str(), "rb"));
  if (!file) {
    failure = "the file cannot be opened";
    return nullptr;
  }
  HdrHeader header;
  failure = read_header(file.get(), header);
  if (!failure.empty()) return nullptr;
  return std::make_unique<HdrReader>(std::move(file), header);
}

}  // namespace glowworm
