#include "image/canvas.h"

#include <stb/stb_easy_font.h>

#include <algorithm>
#include <cmath>

namespace glowworm {

Canvas::Canvas(int columns, int rows, RGB paper)
    : width(columns), height(rows), pixels(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), paper) {}

void Canvas::fill(int x0, int y0, int x1, int y1, RGB color) {
  for (int y = std::max(y0, 0); y < std::min(y1, height); ++y)
    for (int x = std::max(x0, 0); x < std::min(x1, width); ++x)
      pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = color;
}

void Canvas::line(double x0, double y0, double x1, double y1, double thickness, RGB color) {
  const double reach = thickness / 2 + 1, dx = x1 - x0, dy = y1 - y0, squared = dx * dx + dy * dy;
  const auto first = [&](double a, double b) { return std::max(static_cast<int>(std::min(a, b) - reach), 0); };
  const auto last = [&](double a, double b, int most) {
    return std::min(static_cast<int>(std::max(a, b) + reach) + 1, most);
  };
  for (int y = first(y0, y1); y < last(y0, y1, height); ++y)
    for (int x = first(x0, x1); x < last(x0, x1, width); ++x) {
      const double px = x + 0.5 - x0, py = y + 0.5 - y0;
      const double t = squared > 0 ? std::clamp((px * dx + py * dy) / squared, 0.0, 1.0) : 0.0;
      const double covered = thickness / 2 + 0.5 - std::hypot(px - t * dx, py - t * dy);
      if (!(covered > 0)) continue;
      RGB& pixel = pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
      pixel = lerp(pixel, color, static_cast<float>(std::min(covered, 1.0)));
    }
}

void Canvas::write(int x, int y, std::string text, RGB color) {
  struct Corner {
    float x, y, z;
    unsigned char color[4];
  };
  // A glyph has 17 rectangles at most.
  std::vector<Corner> corners(text.size() * 17 * 4);
  const int count = stb_easy_font_print(static_cast<float>(x), static_cast<float>(y), text.data(), nullptr,
                                        corners.data(), static_cast<int>(corners.size() * sizeof(Corner)));
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const Corner &a = corners[4 * i], &b = corners[4 * i + 2];
    fill(static_cast<int>(a.x), static_cast<int>(a.y), static_cast<int>(b.x), static_cast<int>(b.y), color);
  }
}

int Canvas::width_of(std::string text) { return stb_easy_font_width(text.data()); }

Image Canvas::image() const {
  Image out(width, height);
  out.add_rgb("", pixels);
  return out;
}

}  // namespace glowworm
