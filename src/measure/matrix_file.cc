#include "measure/matrix_file.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>

#include "core/error.h"
#include "core/lines.h"
#include "core/text.h"
#include "core/version.h"
#include "measure/measurement.h"

namespace glowworm {

namespace {

constexpr const char* kMatrixForm =
    "Give a matrix with a header, as rfluxmtx, gendaymtx and rmtxop write it: NROWS=, NCOLS=, NCOMP=3, FORMAT=ascii, "
    "float or double, and an empty line.";

struct MatrixHeader {
  double rows = 0, columns = 0, components = 3;
  std::string format = "ascii";
  bool big_endian = false;
};

/// Reads the header and leaves `rest` behind it.
MatrixHeader take_header(std::string_view& rest, const std::string& path) {
  MatrixHeader out;
  int number = 0;
  while (true) {
    if (rest.empty()) throw Error({path, number}, "the file ends within the header of a matrix", kMatrixForm);
    const std::string_view line = take_line(rest);
    ++number;
    if (line.empty()) break;
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string_view key = line.substr(0, equals);
    const std::string value(line.substr(equals + 1));
    if (key == "FORMAT") out.format = value;
    if (key == "BigEndian") out.big_endian = value == "1";
    for (const auto& [name, target] :
         {std::pair{"NROWS", &out.rows}, std::pair{"NCOLS", &out.columns}, std::pair{"NCOMP", &out.components}}) {
      if (key != name) continue;
      const std::vector<double> v = numbers_of<double>(value);
      if (v.size() != 1 || !(v[0] >= 1 && v[0] <= 1e9) || v[0] != std::floor(v[0]))
        throw Error({path, number}, fmt::format("'{}' is no count", line.substr(0, 80)), kMatrixForm);
      *target = v[0];
    }
  }
  if (out.rows == 0 || out.columns == 0)
    throw Error({path}, "is no matrix: its header has no NROWS and NCOLS", kMatrixForm);
  if (out.components != 1 && out.components != 3)
    throw Error({path}, fmt::format("has {} components an element; 1 and 3 are possible", out.components), kMatrixForm);
  return out;
}

/// Takes the next numbers from the body of a file.
class MatrixBody {
 public:
  MatrixBody(std::string_view rest, const MatrixHeader& header, const std::string& path)
      : rest_(rest), path_(path), swap_(header.big_endian != (std::endian::native == std::endian::big)) {
    bytes_ = header.format == "ascii" ? 0 : header.format == "float" ? 4 : header.format == "double" ? 8 : -1;
    if (bytes_ < 0)
      throw Error({path}, fmt::format("the format '{}' is not known", header.format.substr(0, 40)), kMatrixForm);
  }

  float take() {
    double value = 0;
    if (bytes_ == 0) {
      while (!rest_.empty() && std::strchr(" \t\r\n", rest_.front())) rest_.remove_prefix(1);
      if (!take_number(rest_, value)) refuse();
    } else {
      const auto size = static_cast<std::size_t>(bytes_);
      if (rest_.size() < size) refuse();
      char bytes[8];
      for (std::size_t i = 0; i < size; ++i) bytes[i] = rest_[swap_ ? size - 1 - i : i];
      rest_.remove_prefix(size);
      float single = 0;
      if (size == 4) std::memcpy(&single, bytes, 4), value = single;
      if (size == 8) std::memcpy(&value, bytes, 8);
    }
    ++taken_;
    if (!std::isfinite(static_cast<float>(value))) refuse();
    return static_cast<float>(value);
  }

 private:
  [[noreturn]] void refuse() const {
    throw Error({path_}, fmt::format("number {} of the matrix is missing or not finite", taken_ + 1), kMatrixForm);
  }

  std::string_view rest_;
  std::string path_;
  int bytes_ = 0;  // of a number; 0: text
  bool swap_ = false;
  std::size_t taken_ = 0;
};

}  // namespace

std::string matrix_text(const ColorMatrix& m, const std::string& about) {
  std::string text = fmt::format("#?RADIANCE\n{}\nSOFTWARE= glowworm {}\nNCOMP=3\nNROWS={}\nNCOLS={}\nFORMAT=ascii\n\n",
                                 one_line(about), version(), m.rows, m.columns);
  for (std::size_t row = 0; row < m.rows; ++row) {
    for (std::size_t column = 0; column < m.columns; ++column) {
      const RGB v = m.at(row, column);
      fmt::format_to(std::back_inserter(text), "{:.6e}\t{:.6e}\t{:.6e}\t", v.r, v.g, v.b);
    }
    text += '\n';
  }
  return text;
}

ColorMatrix parse_matrix(std::string_view text, const std::string& path) {
  const MatrixHeader header = take_header(text, path);
  ColorMatrix out;
  out.rows = static_cast<std::size_t>(header.rows);
  out.columns = static_cast<std::size_t>(header.columns);
  // Each number takes two characters or more.
  if (header.rows * header.columns * header.components > static_cast<double>(text.size()))
    throw Error({path}, fmt::format("is too short for a matrix of {} x {}", out.rows, out.columns), kMatrixForm);
  MatrixBody body(text, header, path);
  out.value.reserve(out.rows * out.columns);
  for (std::size_t i = 0; i < out.rows * out.columns; ++i) {
    RGB v(body.take());
    if (header.components == 3) v.g = body.take(), v.b = body.take();
    out.value.push_back(v);
  }
  return out;
}

}  // namespace glowworm
