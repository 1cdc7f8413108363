#include "image/html_page.h"

#include <Imath/half.h>
#include <fmt/format.h>
#include <zlib.h>

#include <cstdint>

#include "core/error.h"
#include "image/compare_script.h"

namespace glowworm {

namespace {

constexpr const char* kStyle = R"(
body { font: 14px/1.5 system-ui, sans-serif; margin: 1.5em auto; max-width: 1400px; padding: 0 1em; color: #222; }
h1 { font-size: 1.4em; margin: 0; }
.about { color: #666; overflow-wrap: anywhere; margin: 0 0 1em; }
.controls { display: flex; flex-wrap: wrap; gap: .5em 1.5em; margin-bottom: .5em; }
.controls label { display: flex; gap: .5em; align-items: center; }
.row { display: flex; flex-wrap: wrap; gap: 1.5em; align-items: flex-start; margin-top: 1em; }
canvas, img { max-width: 100%; image-rendering: pixelated; background: #ddd; }
figure { margin: 0; } figcaption { color: #666; }
table { border-collapse: collapse; } td { padding: .1em 1em .1em 0; border-bottom: 1px solid #ddd; }
td + td { text-align: right; font-variant-numeric: tabular-nums; padding-right: 0; }
output { font-variant-numeric: tabular-nums; min-height: 1.5em; display: block; }
)";

/// The beauty as planes R, G, B of little-endian 16-bit floats, compressed by zlib, in base64.
std::string packed_half(const Image& image) {
  std::string halves;
  halves.reserve(image.pixel_count() * 6);
  const std::vector<RGB> pixels = image.rgb();
  for (int c = 0; c < 3; ++c)
    for (const RGB& pixel : pixels) {
      const std::uint16_t bits = Imath::half(pixel[c]).bits();
      halves += static_cast<char>(bits & 0xff);
      halves += static_cast<char>(bits >> 8);
    }
  uLongf size = compressBound(halves.size());
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(halves.data()),
                halves.size(), Z_BEST_SPEED) != Z_OK)
    throw Error("cannot compress a picture");
  packed.resize(size);
  return base64(packed);
}

constexpr const char* kCompareBody = R"(
<div class="controls">
<label>view <select id="view">
<option value="slider">slider</option><option value="difference">difference</option>
<option value="image">picture</option><option value="reference">reference</option></select></label>
<label>split <input id="split" type="range" min="0" max="1" step="any" value="0.5"></label>
<label>exposure <input id="exposure" type="range" min="-10" max="10" step="0.1"><span id="stops"></span></label>
<label>tone <select id="tone"><option>filmic</option><option>srgb</option></select></label>
<label>full colour at <select id="full"><option value="0.02">2%</option><option value="0.1">10%</option>
<option value="0.5" selected>50%</option></select></label>
</div>
<canvas id="main"></canvas>
<output id="pixel">Point at a pixel for its numbers; drag a rectangle to zoom, click to show all.</output>
<div class="row">
<figure><canvas id="zoom-image"></canvas><figcaption>picture</figcaption></figure>
<figure><canvas id="zoom-reference"></canvas><figcaption>reference</figcaption></figure>
<figure><canvas id="zoom-difference"></canvas>
<figcaption>difference: red is too bright, blue too dark, green not finite</figcaption></figure>
</div>
<div class="row">
<figure><figcaption>measures of the whole picture</figcaption>)";

constexpr const char* kCompareEnd = R"(</figure>
<figure><figcaption>measures of the region</figcaption><table id="region"></table></figure>
<figure><canvas id="histogram" width="480" height="200"></canvas>
<figcaption>luminance in stops: picture filled, reference as a line</figcaption></figure>
</div>
)";

}  // namespace

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string html_page(std::string_view title, std::string_view about, std::string_view body, std::string_view script) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width\">\n<title>{0}</title>\n<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n<p "
      "class=\"about\">{2}</p>\n{3}\n<script>\n{4}</script>\n</body>\n</html>\n",
      html_text(title), kStyle, html_text(about), body, script);
}

std::string html_table(const std::vector<std::pair<std::string, std::string>>& rows) {
  std::string out = "<table>\n";
  for (const auto& [name, value] : rows)
    out += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", html_text(name), html_text(value));
  return out + "</table>\n";
}

std::string base64(std::string_view bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t j = 0; j < 3; ++j)
      bits = bits << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j) out += i + j > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * j) & 63];
  }
  return out;
}

std::string html_picture(std::string_view id, std::string_view png) {
  return fmt::format("<img id=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\">\n", id, id, base64(png));
}

std::string compare_page(const Image& image, const Image& reference, const ImageComparison& m, std::string_view about) {
  const auto number = [](double value) { return fmt::format("{:.6g}", value); };
  const std::string table = html_table({{"MSE", number(m.mse)},
                                        {"relMSE", number(m.relative_mse)},
                                        {"relRMSE", number(m.relative_rmse)},
                                        {"PSNR", fmt::format("{:.4g} dB", m.psnr)},
                                        {"mean ratio", number(m.luminance_ratio)},
                                        {"largest difference", number(m.largest_difference)},
                                        {"pixels", fmt::format("{} x {}", image.width(), image.height())},
                                        {"not finite", fmt::format("{}", m.non_finite_pixels)}});
  const std::string script =
      fmt::format("const data = {{width: {}, height: {}, exposure: {:.2f},\n  image: \"{}\",\n  reference: \"{}\"}};\n",
                  image.width(), image.height(), automatic_exposure(reference.rgb()), packed_half(image),
                  packed_half(reference)) +
      kCompareScript;
  return html_page("Comparison of pictures", about, kCompareBody + table + kCompareEnd, script);
}

}  // namespace glowworm
