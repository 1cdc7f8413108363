// IES LM-63-86, -91, -95, -02 and -19: "Standard File Format for the Electronic Transfer of Photometric Data".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "core/error.h"
#include "core/input_file.h"
#include "core/lines.h"
#include "core/text.h"
#include "import/ies/luminaire.h"
#include "import/ies/luminous_opening.h"
#include "import/ies/photometric_text.h"

namespace glowworm {

namespace {

constexpr int kMostAngles = 100'000;

struct Tables {
  std::vector<float> vertical, horizontal;  // degrees
  std::vector<float> candela;               // a row for each horizontal angle
  TiltFactors tilt;
};

bool near(float a, float b) { return std::abs(a - b) < kAngleRounding; }

std::vector<float> radians(const std::vector<float>& degrees) {
  std::vector<float> out;
  for (const float angle : degrees) out.push_back(static_cast<float>(angle * M_PI / 180));
  return out;
}

/// A table of TILT, which stands behind TILT=INCLUDE or in a file of its own.
TiltFactors tilt_factors(PhotometricText& text) {
  text.count("the lamp's place", text.number("the lamp's place"), 1, 3);
  const auto pairs = static_cast<std::size_t>(
      text.count("the number of tilt angles", text.number("the number of tilt angles"), 1, kMostAngles));
  const std::vector<float> angles = text.numbers("the angles of tilt", pairs);
  std::vector<float> factors = text.numbers("the factors of tilt", pairs);
  for (std::size_t i = 0; i < pairs; ++i) {
    if (!(factors[i] >= 0)) text.fail(fmt::format("the factor of tilt {:g} is negative", factors[i]));
    if (i > 0 && !(angles[i] > angles[i - 1])) text.fail(fmt::format("tilt angle {:g} is out of order", angles[i]));
  }
  return {radians(angles), std::move(factors)};
}

TiltFactors read_tilt(PhotometricText& text, std::string_view name) {
  const std::string word = lower(name);
  if (word == "none") return {};
  if (word == "include") return tilt_factors(text);
  const std::string path = std::filesystem::path(text.path()).parent_path() / std::string(name);
  const std::string file = read_input_file(path);
  PhotometricText other(file, path);
  TiltFactors tilt = tilt_factors(other);
  other.check_end("the factors of tilt");
  return tilt;
}

void check_ascending(const PhotometricText& text, const char* what, const std::vector<float>& angles, float least,
                     float most) {
  for (std::size_t i = 0; i < angles.size(); ++i)
    if (angles[i] < least - kAngleRounding || angles[i] > most + kAngleRounding ||
        (i > 0 && !(angles[i] > angles[i - 1])))
      text.fail(
          fmt::format("{} angle {:g} is out of order or beyond {:g} to {:g} degrees", what, angles[i], least, most));
}

/// Adds the mirror images of the rows around the angle `axis`, before or behind them.
void mirror(Tables& t, float axis) {
  const std::size_t columns = t.vertical.size();
  std::vector<std::pair<float, std::vector<float>>> rows;
  for (std::size_t i = 0; i < t.horizontal.size(); ++i) {
    const auto begin = t.candela.begin() + static_cast<std::ptrdiff_t>(i * columns);
    const std::vector<float> row(begin, begin + static_cast<std::ptrdiff_t>(columns));
    rows.emplace_back(t.horizontal[i], row);
    if (!near(t.horizontal[i], axis)) rows.emplace_back(2 * axis - t.horizontal[i], row);
  }
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  t.horizontal.clear();
  t.candela.clear();
  for (const auto& [angle, row] : rows) {
    t.horizontal.push_back(angle);
    t.candela.insert(t.candela.end(), row.begin(), row.end());
  }
}

/// Puts angles that are off by rounding into the ranges of the vertical and the horizontal ones.
void settle(Tables& t, float least_vertical, float most_vertical, float least_horizontal, float most_horizontal) {
  const std::size_t columns = t.vertical.size();
  const std::vector<std::size_t> rows = settle_angles(t.horizontal, least_horizontal, most_horizontal);
  std::vector<float> candela;
  for (const std::size_t row : rows)
    candela.insert(candela.end(), t.candela.begin() + static_cast<std::ptrdiff_t>(row * columns),
                   t.candela.begin() + static_cast<std::ptrdiff_t>((row + 1) * columns));
  t.candela = kept_columns(candela, columns, settle_angles(t.vertical, least_vertical, most_vertical));
}

IntensityTable type_c(const PhotometricText& text, Tables t) {
  check_ascending(text, "vertical", t.vertical, 0, 180);
  check_ascending(text, "horizontal", t.horizontal, 0, 360);
  settle(t, 0, 180, 0, 360);
  const float first = t.horizontal.front(), last = t.horizontal.back();
  if (t.horizontal.size() > 1) {
    if (near(first, 0) && near(last, 90)) {
      mirror(t, 90);
      mirror(t, 180);
    } else if (near(first, 0) && near(last, 180)) {
      mirror(t, 180);
    } else if (near(first, 90) && near(last, 270)) {
      mirror(t, 270);
    } else if (near(first, 0) && last > 180) {
      // Files that leave out 360 degrees mean 0 again.
      if (!near(last, 360)) {
        t.horizontal.push_back(360);
        t.candela.insert(t.candela.end(), t.candela.begin(),
                         t.candela.begin() + static_cast<std::ptrdiff_t>(t.vertical.size()));
      }
    } else {
      text.fail(fmt::format("the horizontal angles run from {:g} to {:g} degrees, which is no symmetry of type C",
                            first, last));
    }
  }
  return {TablePole::forward, radians(t.horizontal), radians(t.vertical), std::move(t.candela), std::move(t.tilt)};
}

/// Types A and B: the polar angle is 90 degrees less the latitude, which is the vertical angle of A and the horizontal
/// one of B; the other is the azimuth.
IntensityTable type_a_or_b(const PhotometricText& text, Tables t, bool is_a) {
  const float tall = is_a ? 90 : 180, wide = is_a ? 180 : 90;
  check_ascending(text, "vertical", t.vertical, -tall, tall);
  check_ascending(text, "horizontal", t.horizontal, -wide, wide);
  settle(t, -tall, tall, -wide, wide);
  if (near(t.horizontal.front(), 0) && t.horizontal.size() > 1) mirror(t, 0);
  const std::vector<float>& latitudes = is_a ? t.vertical : t.horizontal;
  const std::vector<float>& azimuths = is_a ? t.horizontal : t.vertical;
  if (latitudes.size() < 2 || azimuths.size() < 2) text.fail("types A and B need two angles in each direction");
  std::vector<float> polar, values;
  for (std::size_t i = latitudes.size(); i-- > 0;) polar.push_back(std::max(90 - latitudes[i], 0.0f));
  for (std::size_t a = 0; a < azimuths.size(); ++a)
    for (std::size_t l = latitudes.size(); l-- > 0;)
      values.push_back(t.candela[is_a ? a * latitudes.size() + l : l * azimuths.size() + a]);
  return {is_a ? TablePole::up : TablePole::right, radians(azimuths), radians(polar), std::move(values),
          std::move(t.tilt)};
}

/// The year of the edition of the standard that the first line names.
int edition_of(std::string_view line) {
  struct Edition {
    std::string_view name;
    int year;
  };
  constexpr Edition kEditions[] = {
      {"IES:LM-63-", 2019}, {"IESNA:LM-63-2002", 2002}, {"IESNA:LM-63-1995", 1995}, {"IESNA91", 1991}};
  for (const Edition& edition : kEditions)
    if (line.starts_with(edition.name)) return edition.year;
  return 1986;
}

/// Takes the name of the luminaire from a line of keywords, or keeps what is known better.
void note_name(std::string_view line, std::string& name) {
  constexpr std::string_view kName = "[LUMINAIRE]", kNumber = "[LUMCAT]";
  if (line.starts_with(kName)) name = trimmed(line.substr(kName.size()));
  if (line.starts_with(kNumber) && name.empty()) name = trimmed(line.substr(kNumber.size()));
}

/// The type, unit and sizes of the opening.
LuminousOpening read_opening(PhotometricText& text, int edition) {
  constexpr float kFoot = 0.3048f;
  const float unit = text.count("the unit of length", text.number("the unit of length"), 1, 2) == 1 ? kFoot : 1.0f;
  const float width = unit * text.number("the width"), length = unit * text.number("the length");
  return lm63_opening(width, length, unit * text.number("the height"), edition);
}

}  // namespace

PhotometricFile parse_lm63(std::string_view bytes, const std::string& path) {
  PhotometricText text(bytes, path);
  std::string_view line = trimmed(text.line("the first line"));
  const int edition = edition_of(line);
  std::string name;
  while (!lower(line).starts_with("tilt=")) {
    line = trimmed(text.line("the labels, without a line TILT="));
    note_name(line, name);
  }
  Tables t;
  t.tilt = read_tilt(text, trimmed(line.substr(5)));
  LampSet lamps;
  const float count = text.number("the number of lamps"), flux = text.number("the flux of a lamp");
  lamps.flux = std::max(count * flux, 0.0f);  // -1 where the intensities are absolute
  float factor = text.number("the factor of the intensities");
  const auto vertical = static_cast<std::size_t>(
      text.count("the number of vertical angles", text.number("the number of vertical angles"), 2, kMostAngles));
  const auto horizontal = static_cast<std::size_t>(
      text.count("the number of horizontal angles", text.number("the number of horizontal angles"), 1, kMostAngles));
  const int type = text.count("the photometric type", text.number("the photometric type"), 1, 3);
  const LuminousOpening opening = read_opening(text, edition);
  factor *= text.number("the ballast factor");
  const float second = text.number("the ballast-lamp factor");
  // Since 2019 the second factor is a code of how the file was made.
  if (edition < 2019) factor *= second;
  lamps.power = std::max(text.number("the power"), 0.0f);
  t.vertical = text.numbers("the vertical angles", vertical);
  t.horizontal = text.numbers("the horizontal angles", horizontal);
  t.candela = text.numbers("the intensities", vertical * horizontal);
  text.check_end("the intensities");
  for (float& value : t.candela)
    if (value *= factor; !(value >= 0 && std::isfinite(value)))
      text.fail(fmt::format("an intensity of {:g} cd", value));
  return {type == 1 ? type_c(text, std::move(t)) : type_a_or_b(text, std::move(t), type == 3),
          opening,
          std::move(name),
          {lamps},
          0};
}

}  // namespace glowworm
