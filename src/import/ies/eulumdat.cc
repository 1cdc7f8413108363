// EULUMDAT, A. Stockmar, "EULUMDAT - ein Leuchtendatenformat fuer den europaeischen Beleuchtungsplaner", Licht '90.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/lines.h"
#include "import/ies/luminaire.h"
#include "import/ies/photometric_text.h"

namespace glowworm {

namespace {

constexpr int kMaxAngles = 10'000;
/// Lines between the number of lamps' sets and the planes: six for each set, and ten direct ratios.
constexpr std::size_t kDirectRatios = 10;

/// The planes of the file by the symmetry: the first, counted from 0, and how many.
std::pair<std::size_t, std::size_t> planes_of(int symmetry, std::size_t planes) {
  switch (symmetry) {
    case 1:
      return {0, 1};
    case 2:
      return {0, planes / 2 + 1};
    case 3:
      return {3 * planes / 4, planes / 2 + 1};
    case 4:
      return {0, planes / 4 + 1};
    default:
      return {0, planes};
  }
}

/// The row of the file that holds plane i of all.
std::size_t row_of(int symmetry, std::size_t i, std::size_t planes) {
  const auto mirrored = [&](std::size_t axis_twice) { return (axis_twice + planes - i) % planes; };
  switch (symmetry) {
    case 1:
      return 0;
    case 2:  // around C0 to C180
      return i <= planes / 2 ? i : mirrored(0);
    case 3: {  // around C90 to C270: the file begins at C270 and goes up to C90
      const bool in_file = i <= planes / 4 || i >= 3 * planes / 4;
      const std::size_t plane = in_file ? i : mirrored(planes / 2);
      return (plane + planes - 3 * planes / 4) % planes;
    }
    case 4: {
      const std::size_t half = i <= planes / 2 ? i : mirrored(0);
      return half <= planes / 4 ? half : planes / 2 - half;
    }
    default:
      return i;
  }
}

/// The sizes of the file (mm), of the luminaire and of its luminous area.
LuminousOpening read_opening(PhotometricText& text) {
  // A blank is an unknown size.
  text.optional_number_lines("the size of the luminaire", 3);
  const std::vector<float> area = text.optional_number_lines("the size of the luminous area", 2);
  const std::vector<float> heights = text.optional_number_lines("the heights of the luminous area", 4);
  LuminousOpening out;
  const float length = std::abs(area[0]) / 1000, width = std::abs(area[1]) / 1000;
  out.size = {width, length, std::max(*std::max_element(heights.begin(), heights.end()), 0.0f) / 1000};
  if (width == 0) {
    out.shape = LuminousOpening::Shape::cylinder;
    out.size.x = length;
  }
  return out;
}

std::vector<LampSet> read_lamp_sets(PhotometricText& text, std::size_t count) {
  std::vector<LampSet> out(count);
  for (LampSet& set : out) {
    text.skip_number_lines("the number of lamps", 1);
    set.name = trimmed(text.line("the type of lamps"));
    set.flux = text.number_line("the flux of lamps");
    for (const char* what : {"the colour of lamps", "the colour rendering of lamps"}) text.line(what);
    set.power = text.optional_number_lines("the power of lamps", 1)[0];
  }
  return out;
}

/// The index of a set by its name or its number, from 1; the first without.
std::size_t set_of(const std::vector<LampSet>& sets, const std::string& lamps, const PhotometricText& text) {
  if (lamps.empty()) return 0;
  std::string names;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    if (sets[i].name == lamps || std::to_string(i + 1) == lamps) return i;
    names += fmt::format("{}{} '{}'", i > 0 ? ", " : "", i + 1, sets[i].name);
  }
  throw Error({text.path()}, fmt::format("has no set of lamps '{}'", lamps), "It has " + names + ".");
}

}  // namespace

PhotometricFile parse_eulumdat(std::string_view bytes, const std::string& path, const std::string& lamps) {
  PhotometricText text(bytes, path);
  text.line("the company");
  const auto count = [&](const char* what, int least, int most) {
    return text.count(what, text.number_line(what), least, most);
  };
  // Files leave blank what is unknown; blanks are refused only where the number matters.
  text.skip_number_lines("the type of luminaire", 1);
  const int symmetry = count("the symmetry", 0, 4);
  const auto planes = static_cast<std::size_t>(count("the number of C planes", 1, kMaxAngles));
  text.skip_number_lines("the distance of C planes", 1);
  const auto angles = static_cast<std::size_t>(count("the number of angles of a plane", 2, kMaxAngles));
  text.skip_number_lines("the distance of angles", 1);
  if ((symmetry == 2 && planes % 2 != 0) || (symmetry > 2 && planes % 4 != 0))
    text.fail(fmt::format("{} C planes do not have symmetry {}", planes, symmetry));
  text.line("the report");
  const std::string name(trimmed(text.line("the name")));
  for (const char* what : {"the number", "the file name", "the date"}) text.line(what);
  const LuminousOpening opening = read_opening(text);
  text.skip_number_lines("the shares of light", 2);
  const float factor = text.number_line("the factor of the intensities");
  text.skip_number_lines("the tilt", 1);
  std::vector<LampSet> sets =
      read_lamp_sets(text, static_cast<std::size_t>(count("the number of sets of lamps", 1, 20)));
  const std::size_t set = set_of(sets, lamps, text);
  text.skip_number_lines("the direct ratios", kDirectRatios);
  std::vector<float> c = text.number_lines("the C angles", planes);
  std::vector<float> polar = text.number_lines("the angles of a plane", angles);
  const std::size_t rows = planes_of(symmetry, planes).second;
  text.check_room("the intensities", rows * angles);
  // Candela for 1000 lm.
  const float scale = factor * sets[set].flux / 1000;
  std::vector<float> file = text.number_lines("the intensities", rows * angles);
  text.check_end("the intensities");
  for (float& value : file)
    if (value *= scale; !(value >= 0 && std::isfinite(value))) text.fail(fmt::format("an intensity of {:g} cd", value));
  for (const float angle : polar)
    if (!(angle >= -kAngleRounding && angle <= 180 + kAngleRounding))
      text.fail(fmt::format("{:g} is no angle from 0 to 180 degrees", angle));
  file = kept_columns(file, angles, settle_angles(polar, 0, 180));
  const std::size_t columns = polar.size();
  for (float& angle : polar) angle = static_cast<float>(angle * M_PI / 180);
  if (symmetry == 1)
    return {{TablePole::forward, {0}, std::move(polar), std::move(file)}, opening, name, std::move(sets), set};
  std::vector<float> azimuths, values;
  for (std::size_t i = 0; i <= planes; ++i) {
    azimuths.push_back(static_cast<float>((i < planes ? c[i] : c[0] + 360) * M_PI / 180));
    const std::size_t row = row_of(symmetry, i % planes, planes);
    values.insert(values.end(), file.begin() + static_cast<std::ptrdiff_t>(row * columns),
                  file.begin() + static_cast<std::ptrdiff_t>((row + 1) * columns));
  }
  return {{TablePole::forward, std::move(azimuths), std::move(polar), std::move(values)},
          opening,
          name,
          std::move(sets),
          set};
}

}  // namespace glowworm
