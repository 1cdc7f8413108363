#include "image/false_color.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/round_step.h"
#include "core/vec.h"
#include "image/canvas.h"

namespace glowworm {

RGB false_color(float t) {
  constexpr int kStops = 7;
  static const RGB stops[kStops] = {{0, 0, 0.02f},   {0, 0, 0.8f},     {0, 0.6f, 0.8f}, {0, 0.6f, 0.05f},
                                    {0.9f, 0.8f, 0}, {0.9f, 0.05f, 0}, {1, 1, 1}};
  const float at = std::clamp(t, 0.0f, 1.0f) * (kStops - 1);
  const int below = std::min(static_cast<int>(at), kStops - 2);
  return lerp(stops[below], stops[below + 1], at - static_cast<float>(below));
}

ColorScale fitting_scale(std::span<const float> values) {
  std::vector<float> positive;
  for (const float v : values)
    if (v > 0 && std::isfinite(v)) positive.push_back(v);
  if (positive.empty()) return {1, 10};
  const auto percentile = [&](double share) {
    const auto place = positive.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(positive.size() - 1));
    std::nth_element(positive.begin(), place, positive.end());
    return *place;
  };
  const float low = percentile(0.02), high = percentile(0.98);
  // A scale needs some width.
  return {low, std::max(high, 2 * low)};
}

std::vector<RGB> false_colors(std::span<const float> values, ColorScale scale) {
  std::vector<RGB> colors(values.size());
  const float low = std::log(scale.low), width = std::log(scale.high) - low;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] > 0) colors[i] = false_color((std::log(values[i]) - low) / width);
  return colors;
}

std::vector<float> scale_ticks(ColorScale scale) {
  // Multiples of powers of ten, ever finer until there are enough.
  static const std::vector<std::vector<float>> kMultiples = {{1}, {1, 3}, {1, 2, 5}, {1, 1.5f, 2, 3, 4, 5, 6, 8}};
  constexpr std::size_t kEnough = 5;
  std::vector<float> ticks;
  const auto take = [&](double value) {
    if (value >= scale.low && value <= scale.high) ticks.push_back(static_cast<float>(value));
  };
  for (const std::vector<float>& multiples : kMultiples) {
    if (ticks.size() >= kEnough) return ticks;
    ticks.clear();
    for (double power = std::floor(std::log10(scale.low)); power <= std::log10(scale.high); ++power)
      for (const float multiple : multiples) take(multiple * std::pow(10.0, power));
  }
  if (ticks.size() >= kEnough) return ticks;
  ticks.clear();
  const double step = round_step_below((scale.high - scale.low) / kEnough);
  for (double i = std::ceil(scale.low / step); i * step <= scale.high; ++i) take(i * step);
  return ticks;
}

namespace {

constexpr int kLegendWidth = 96, kBarWidth = 16, kMargin = 10, kLineHeight = Canvas::kLineHeight, kLeastHeight = 160;
const RGB kPaper(0.9f), kInk(0.02f), kNothing(0.3f);

/// Means over squares of five pixels, so that single noisy pixels have no isolines of their own.
std::vector<float> smoothed(std::span<const float> values, int width, int height) {
  std::vector<float> out(values.begin(), values.end());
  std::vector<float> line;
  const auto smooth = [&](std::size_t first, std::size_t step, int count) {
    line.assign(static_cast<std::size_t>(count), 0);
    for (int i = 0; i < count; ++i) {
      float sum = 0, weight = 0;
      for (int j = std::max(i - 2, 0); j <= std::min(i + 2, count - 1); ++j)
        if (const float v = out[first + static_cast<std::size_t>(j) * step]; std::isfinite(v)) sum += v, ++weight;
      line[static_cast<std::size_t>(i)] = weight > 0 ? sum / weight : out[first + static_cast<std::size_t>(i) * step];
    }
    for (std::size_t i = 0; i < line.size(); ++i) out[first + i * step] = line[i];
  };
  const auto columns = static_cast<std::size_t>(width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) smooth(y * columns, 1, width);
  for (std::size_t x = 0; x < columns; ++x) smooth(x, columns, height);
  for (std::size_t i = 0; i < out.size(); ++i)
    if (!std::isfinite(values[i])) out[i] = values[i];
  return out;
}

/// Draws a dark pixel wherever a tick lies between a pixel and its neighbour to the right or below.
void draw_isolines(std::span<const float> values, int width, int height, std::span<const float> ticks, Canvas& canvas) {
  const std::vector<float> smooth = smoothed(values, width, height);
  const auto at = [&](int x, int y) {
    return smooth[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  };
  const auto band = [&](float value) { return std::upper_bound(ticks.begin(), ticks.end(), value) - ticks.begin(); };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float here = at(x, y), right = x + 1 < width ? at(x + 1, y) : here,
                  below = y + 1 < height ? at(x, y + 1) : here;
      if (!std::isfinite(here)) continue;
      if ((std::isfinite(right) && band(right) != band(here)) || (std::isfinite(below) && band(below) != band(here)))
        canvas.fill(x, y, x + 1, y + 1, kInk);
    }
}

void draw_legend(int left, ColorScale scale, std::span<const float> ticks, const std::string& unit, Canvas& canvas) {
  const int top = kMargin + kLineHeight + 6, bottom = canvas.height - kMargin, x = left + kMargin;
  canvas.write(x, kMargin, unit, kInk);
  for (int y = top; y < bottom; ++y)
    canvas.fill(x, y, x + kBarWidth, y + 1,
                false_color((static_cast<float>(bottom - y) - 0.5f) / static_cast<float>(bottom - top)));
  int free_below = canvas.height;
  for (const float tick : ticks) {
    const float t = std::log(tick / scale.low) / std::log(scale.high / scale.low);
    const int y = std::min(bottom - static_cast<int>(std::lround(t * static_cast<float>(bottom - top))), bottom - 1);
    canvas.fill(x, y, x + kBarWidth + 4, y + 1, kInk);
    if (y + kLineHeight / 2 > free_below) continue;
    canvas.write(x + kBarWidth + 8, y - 4, fmt::format("{:g}", tick), kInk);
    free_below = y - kLineHeight / 2;
  }
}

}  // namespace

Image false_color_plot(std::span<const float> values, int width, int height, ColorScale scale,
                       const std::string& unit) {
  Canvas canvas(width + kLegendWidth, std::max(height, kLeastHeight), kPaper);
  const std::vector<RGB> colors = false_colors(values, scale);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
      canvas.fill(x, y, x + 1, y + 1, std::isnan(values[i]) ? kNothing : colors[i]);
    }
  const std::vector<float> ticks = scale_ticks(scale);
  draw_isolines(values, width, height, ticks, canvas);
  draw_legend(width, scale, ticks, unit, canvas);
  return canvas.image();
}

std::vector<float> illuminance_of(const Image& image) {
  // Darker surfaces send back too little light to tell it.
  constexpr float kLeastAlbedo = 0.01f;
  for (const std::string name : kLayersOfIlluminance)
    if (!image.has_channel(name + ".R"))
      throw Error(fmt::format("--false-color lux needs the layer {}", name),
                  fmt::format("Render with --aov {}.", fmt::join(kLayersOfIlluminance, ",")));
  const std::vector<RGB> light = image.rgb(), emitted = image.rgb("emitted"), albedo = image.rgb("albedo");
  std::vector<float> values;
  for (std::size_t i = 0; i < light.size(); ++i) {
    RGB irradiance;
    for (int c = 0; c < 3; ++c)
      if (albedo[i][c] > 0) irradiance[c] = kPi * std::max(light[i][c] - emitted[i][c], 0.0f) / albedo[i][c];
    values.push_back(luminance(albedo[i]) < kLeastAlbedo ? std::numeric_limits<float>::quiet_NaN()
                                                         : kLuminousEfficacy * luminance(irradiance));
  }
  return values;
}

}  // namespace glowworm
