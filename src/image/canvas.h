// Diagrams drawn into a picture: filled boxes, lines and short texts.
#pragma once
#include <string>
#include <vector>

#include "core/rgb.h"
#include "image/image.h"

namespace glowworm {

/// A picture to draw on, in linear display RGB; pixels outside are ignored. Write it as PNG with ToneCurve::srgb.
struct Canvas {
  Canvas(int columns, int rows, RGB paper);

  void fill(int x0, int y0, int x1, int y1, RGB color);
  /// Draws a straight line with soft borders between two points, pixels. @param thickness pixels
  void line(double x0, double y0, double x1, double y1, double thickness, RGB color);
  /// Writes ASCII text with its upper left corner at (x, y); a line is kLineHeight high.
  void write(int x, int y, std::string text, RGB color);
  /// Width of a text in pixels.
  static int width_of(std::string text);
  Image image() const;

  static constexpr int kLineHeight = 12;
  int width = 0, height = 0;
  std::vector<RGB> pixels;  ///< row-major, first row on top
};

}  // namespace glowworm
