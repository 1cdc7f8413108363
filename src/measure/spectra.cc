#include "measure/spectra.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/input_file.h"
#include "core/lines.h"
#include "core/text.h"
#include "measure/spectra_tables.h"

namespace glowworm {

namespace {

constexpr double kSecondRadiation = 1.4388e-2;  // m K, as CIE 15:2004 rounds it

template <typename Power>
SampledSpectrum over_visible(Power&& power) {
  SampledSpectrum out;
  for (std::size_t i = 0; i < kVisibleCount; ++i) {
    out.wavelengths.push_back(kVisibleFirst + kVisibleStep * static_cast<double>(i));
    out.values.push_back(power(out.wavelengths.back(), i));
  }
  return out;
}

/// The colour temperature of a daylight illuminant by today's constant in Planck's law: D65 is of 6504 K.
double nominal_daylight(double hundreds) { return hundreds * 100 * kSecondRadiation / 1.438e-2; }

/// Throws Error for a spectrum that is cut off where eyes see: light beyond its ends counts as 0.
void check_ends(const SampledSpectrum& s, const std::string& file) {
  constexpr double kFirst = 400, kLast = 700, kDark = 0.01;  // nm; of the greatest power
  const double dark = kDark * *std::max_element(s.values.begin(), s.values.end());
  const double first = s.wavelengths.front(), last = s.wavelengths.back();
  if ((first > kFirst && s.values.front() > dark) || (last < kLast && s.values.back() > dark) || last < kFirst)
    throw Error({file}, fmt::format("its spectrum from {:g} to {:g} nm is cut off", first, last),
                "Give powers from 380 to 780 nm, and 0 where there is no light.");
}

}  // namespace

SampledSpectrum planck_spectrum(double kelvin) {
  return over_visible([&](double nm, std::size_t) {
    const double metres = nm * 1e-9;
    return std::pow(nm / 560, -5) / std::expm1(kSecondRadiation / (metres * kelvin));
  });
}

SampledSpectrum daylight_spectrum(double kelvin) {
  if (!(kelvin >= 4000 && kelvin <= 25'000))
    throw Error(fmt::format("{:g} K is no colour temperature of daylight", kelvin), "Give 4000 to 25000.");
  const double t = 1000 / kelvin;
  const double x = kelvin <= 7000 ? -4.6070 * t * t * t + 2.9678 * t * t + 0.09911 * t + 0.244063
                                  : -2.0064 * t * t * t + 1.9018 * t * t + 0.24748 * t + 0.237040;
  const double y = -3 * x * x + 2.87 * x - 0.275, m = 0.0241 + 0.2562 * x - 0.7341 * y;
  // The standard rounds the factors to three decimals.
  const double m1 = std::round((-1.3515 - 1.7703 * x + 5.9114 * y) / m * 1000) / 1000;
  const double m2 = std::round((0.0300 - 31.4424 * x + 30.0717 * y) / m * 1000) / 1000;
  SampledSpectrum out;
  for (std::size_t i = 0; i < kDaylightCount; ++i) {
    const auto& [s0, s1, s2] = kDaylightComponents[i];
    out.wavelengths.push_back(kVisibleFirst + kDaylightStep * static_cast<double>(i));
    out.values.push_back(s0 + m1 * s1 + m2 * s2);
  }
  return out;
}

SampledSpectrum parse_spectrum_table(std::string_view text, const std::string& file) {
  // A header and separators of CSV, as .spd files have them.
  std::string plain;
  text = without_byte_order_mark(text);
  while (!text.empty()) {
    std::string line(take_line(text));
    for (char& c : line)
      if (c == ',' || c == ';') c = ' ';
    const std::size_t begin = line.find_first_not_of(" \t\"");
    if (begin != std::string::npos && std::isalpha(static_cast<unsigned char>(line[begin]))) line.insert(0, "#");
    plain += line + "\n";
  }
  SampledSpectrum out = parse_spd(plain, file);
  for (const double value : out.values)
    if (value < 0) throw Error({file}, fmt::format("a power of {:g} is negative", value), "Give 0 or more.");
  check_ends(out, file);
  return out;
}

SampledSpectrum spectrum_of_text(const std::string& text) {
  if (text == "A") return planck_spectrum(2848 * kSecondRadiation / 1.435e-2);
  if (text == "E") return over_visible([](double, std::size_t) { return 1.0; });
  for (const double hundreds : {50.0, 55.0, 65.0, 75.0})
    if (text == fmt::format("D{:g}", hundreds)) return daylight_spectrum(nominal_daylight(hundreds));
  for (const FluorescentLamp& lamp : kFluorescentLamps)
    if (text == lamp.name) return over_visible([&](double, std::size_t i) { return lamp.power[i]; });
  if (const std::vector<double> number = numbers_of<double>(text); number.size() == 1) {
    constexpr double kLeast = 1000, kMost = 25'000, kFirstDaylight = 5000;
    if (number[0] < kLeast || number[0] > kMost)
      throw Error(fmt::format("{:g} K is no colour temperature of a lamp", number[0]), "Give 1000 to 25000.");
    return number[0] < kFirstDaylight ? planck_spectrum(number[0]) : daylight_spectrum(number[0]);
  }
  if (text.find('.') == std::string::npos)
    throw Error(fmt::format("'{}' is no spectrum", text),
                "Give A, D50, D55, D65, D75, E, F2, F7, F11, a colour temperature such as 4000, or a file.");
  return parse_spectrum_table(read_input_file(text), text);
}

}  // namespace glowworm
