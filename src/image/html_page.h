// Reports as one HTML file that loads nothing else.
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "image/image.h"
#include "image/metrics.h"

namespace glowworm {

/// Text with the characters that HTML reserves written as entities.
std::string html_text(std::string_view text);

/// An HTML file with all styles and scripts in it.
/// @param about shown below the title, such as a command line; @param body HTML; @param script JavaScript, or ""
std::string html_page(std::string_view title, std::string_view about, std::string_view body, std::string_view script);

/// A table of two columns. The cells are plain text.
std::string html_table(const std::vector<std::pair<std::string, std::string>>& rows);

/// Bytes in base64 (RFC 4648).
std::string base64(std::string_view bytes);

/// A picture in a PNG file, as an element of a page.
std::string html_picture(std::string_view id, std::string_view png);

/// A page that compares a picture with its reference: slider, difference in false colour, exposure, histogram, zoom
/// into regions, and measures. Pictures are stored as 16-bit floats. Both must have the same size.
std::string compare_page(const Image& image, const Image& reference, const ImageComparison& measures,
                         std::string_view about);

}  // namespace glowworm
