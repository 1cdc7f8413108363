// Matrices of colours as Radiance's tools write and read them: .mtx, .smx, .dc.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/rgb.h"

namespace glowworm {

/// A matrix, row by row.
struct ColorMatrix {
  std::size_t rows = 0, columns = 0;
  std::vector<RGB> value;

  RGB at(std::size_t row, std::size_t column) const { return value[row * columns + column]; }
};

/// The matrix as rfluxmtx, gendaymtx and rcontrib write it: a header with NROWS, NCOLS, NCOMP=3 and FORMAT=ascii, then
/// a line of R G B triples for each row.
/// @param about told in the header, such as the command line
std::string matrix_text(const ColorMatrix& matrix, const std::string& about);

/// Reads such a matrix, with FORMAT ascii, float or double and one component or three. Throws Error, with the line of
/// the header or the element, for other files.
ColorMatrix parse_matrix(std::string_view text, const std::string& path);

}  // namespace glowworm
