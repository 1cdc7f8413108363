#include "import/pbrt/spectrum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>

#include "core/error.h"
#include "core/lines.h"
#include "import/pbrt/spectrum_tables.h"

namespace glowworm {

namespace {

using Triple = std::array<double, 3>;

constexpr double kSecondRadiation = 1.438776877e7;  // h c / k, nm K (CODATA 2018)

double matching_wavelength(int i) { return kMatchingFirst + kMatchingStep * i; }

/// Sum over the visible wavelengths of value(i) times the matching functions.
Triple tristimulus(const std::function<double(int)>& value) {
  Triple xyz{};
  for (int i = 0; i < kMatchingCount; ++i) {
    const double v = value(i);
    for (int c = 0; c < 3; ++c) xyz[c] += v * kMatching[i][c];
  }
  return xyz;
}

/// Sum of the matching function y, the tristimulus value Y of a spectrum that is 1 everywhere.
double matching_sum() {
  static const double sum = tristimulus([](int) { return 1.0; })[1];
  return sum;
}

RGB scaled_rgb(const Triple& xyz, double white) { return rgb_from_xyz(xyz[0] / white, xyz[1] / white, xyz[2] / white); }

/// White of the D65 table in linear RGB, close to 1. Dividing by it makes a perfect reflector exactly white.
RGB daylight_white() {
  static const RGB white = [] {
    const Triple xyz = tristimulus([](int i) { return kDaylight65[i]; });
    return scaled_rgb(xyz, xyz[1]);
  }();
  return white;
}

/// Colour of `value` under D65, unclamped.
RGB under_daylight(const std::function<double(double)>& value) {
  static const double white = tristimulus([](int i) { return kDaylight65[i]; })[1];
  const Triple xyz = tristimulus([&](int i) { return kDaylight65[i] * value(matching_wavelength(i)); });
  return scaled_rgb(xyz, white) / daylight_white();
}

/// Reflectance at normal incidence of a conductor in air.
double normal_reflectance(double eta, double k) {
  return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
}

SampledSpectrum from_table(std::span<const double> wavelengths, std::span<const double> values) {
  return {{wavelengths.begin(), wavelengths.end()}, {values.begin(), values.end()}};
}

}  // namespace

double SampledSpectrum::at(double wavelength) const {
  if (wavelengths.empty() || wavelength < wavelengths.front() || wavelength > wavelengths.back()) return 0;
  const auto above = std::lower_bound(wavelengths.begin(), wavelengths.end(), wavelength);
  const auto i = static_cast<std::size_t>(above - wavelengths.begin());
  if (i == 0 || *above == wavelength) return values[i];
  const double t = (wavelength - wavelengths[i - 1]) / (wavelengths[i] - wavelengths[i - 1]);
  return values[i - 1] + t * (values[i] - values[i - 1]);
}

RGB rgb_from_xyz(double x, double y, double z) {
  return {static_cast<float>(3.2404542 * x - 1.5371385 * y - 0.4985314 * z),
          static_cast<float>(-0.9692660 * x + 1.8760108 * y + 0.0415560 * z),
          static_cast<float>(0.0556434 * x - 0.2040259 * y + 1.0572252 * z)};
}

RGB blackbody_rgb(double kelvin) {
  SampledSpectrum spectrum;
  for (int i = 0; i < kMatchingCount; ++i) {
    const double wavelength = matching_wavelength(i);
    spectrum.wavelengths.push_back(wavelength);
    // Relative to the longest wavelength, so that cold bodies neither underflow nor overflow.
    constexpr double kLongest = kMatchingFirst + kMatchingStep * (kMatchingCount - 1);
    const double exponent = kSecondRadiation / kelvin * (1 / wavelength - 1 / kLongest);
    const double small = 1 - std::exp(-kSecondRadiation / (kelvin * wavelength));
    spectrum.values.push_back(std::exp(-exponent) / small * std::pow(kLongest / wavelength, 5));
  }
  return illuminant_rgb(spectrum);
}

RGB blackbody_rgb_of_peak(double kelvin) {
  constexpr double kWien = 2.897771955e6;  // peak wavelength times temperature, nm K (CODATA 2018)
  const double peak = kWien / kelvin;
  SampledSpectrum spectrum;
  for (int i = 0; i < kMatchingCount; ++i) {
    const double wavelength = matching_wavelength(i);
    spectrum.wavelengths.push_back(wavelength);
    spectrum.values.push_back(std::pow(peak / wavelength, 5) * std::expm1(kSecondRadiation / kWien) /
                              std::expm1(kSecondRadiation / (wavelength * kelvin)));
  }
  return emission_rgb(spectrum);
}

RGB illuminant_rgb(const SampledSpectrum& spectrum) {
  const Triple xyz = tristimulus([&](int i) { return spectrum.at(matching_wavelength(i)); });
  return xyz[1] > 0 ? scaled_rgb(xyz, xyz[1]) : RGB(0.0f);
}

RGB emission_rgb(const SampledSpectrum& spectrum) {
  return scaled_rgb(tristimulus([&](int i) { return spectrum.at(matching_wavelength(i)); }), matching_sum());
}

double luminance_of_constant_spectrum() { return matching_sum() * kMatchingStep; }

RGB reflectance_rgb(const SampledSpectrum& spectrum) {
  return clamp(under_daylight([&](double wavelength) { return spectrum.at(wavelength); }), 0.0f, 1.0f);
}

double photopic_mean(const SampledSpectrum& spectrum) {
  double sum = 0, weight = 0;
  for (int i = 0; i < kMatchingCount; ++i) {
    const double wavelength = matching_wavelength(i);
    if (spectrum.wavelengths.empty() || wavelength < spectrum.wavelengths.front() ||
        wavelength > spectrum.wavelengths.back()) {
      continue;
    }
    sum += kMatching[i][1] * spectrum.at(wavelength);
    weight += kMatching[i][1];
  }
  return weight > 0 ? sum / weight : 0;
}

ConductorIndex conductor_rgb(const SampledSpectrum& eta, const SampledSpectrum& k) {
  ConductorIndex index;
  const RGB mean_eta = under_daylight([&](double wavelength) { return eta.at(wavelength); });
  const RGB reflectance =
      under_daylight([&](double wavelength) { return normal_reflectance(eta.at(wavelength), k.at(wavelength)); });
  for (int c = 0; c < 3; ++c) {
    const double n = std::max(mean_eta[c], 0.01f), r = std::clamp(reflectance[c], 0.0f, 0.9999f);
    // From r = ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2). If no k gives such a low reflectance, k = 0.
    const double squared = (r * (n + 1) * (n + 1) - (n - 1) * (n - 1)) / (1 - r);
    index.eta[c] = static_cast<float>(n);
    index.k[c] = static_cast<float>(std::sqrt(std::max(squared, 0.0)));
  }
  return index;
}

ConductorIndex conductor_from_reflectance(RGB reflectance) {
  ConductorIndex index{RGB(1.0f), RGB(0.0f)};
  for (int c = 0; c < 3; ++c) {
    const float r = std::clamp(reflectance[c], 0.0f, 0.9999f);
    index.k[c] = 2 * std::sqrt(r / (1 - r));
  }
  return index;
}

std::optional<MetalSpectra> named_metal(std::string_view name) {
  if (name == "CuZn") {
    std::array<double, kBrassCount> wavelengths{};
    for (int i = 0; i < kBrassCount; ++i) wavelengths[i] = kBrassFirst + kBrassStep * i;
    return MetalSpectra{from_table(wavelengths, kBrassEta), from_table(wavelengths, kBrassK)};
  }
  for (const MetalTable& metal : kMetals) {
    if (metal.name == name) {
      return MetalSpectra{from_table(kMetalWavelengths, metal.eta), from_table(kMetalWavelengths, metal.k)};
    }
  }
  return std::nullopt;
}

std::optional<float> named_glass(std::string_view name) {
  struct Glass {
    std::string_view name;
    float index;  // at 587.6 nm, by the makers' data sheets
  };
  constexpr Glass kGlasses[] = {{"glass-BK7", 1.5168f},    {"glass-BAF10", 1.67003f}, {"glass-FK51A", 1.48656f},
                                {"glass-LASF9", 1.85025f}, {"glass-F5", 1.6727f},     {"glass-SF5", 1.6727f},
                                {"glass-F10", 1.72825f},   {"glass-SF10", 1.72825f},  {"glass-F11", 1.78472f},
                                {"glass-SF11", 1.78472f}};
  for (const Glass& glass : kGlasses) {
    if (glass.name == name) return glass.index;
  }
  return std::nullopt;
}

std::optional<RGB> named_illuminant(std::string_view name) {
  struct Illuminant {
    std::string_view name;
    double x, y;  // chromaticity (CIE 15:2004, table T.3; ACES white: SMPTE ST 2065-1)
  };
  constexpr Illuminant kIlluminants[] = {
      {"stdillum-A", 0.44758, 0.40745},   {"stdillum-D50", 0.34567, 0.35851}, {"stdillum-D65", 0.31272, 0.32903},
      {"stdillum-F1", 0.3131, 0.3371},    {"stdillum-F2", 0.3721, 0.3751},    {"stdillum-F3", 0.4091, 0.3941},
      {"stdillum-F4", 0.4402, 0.4031},    {"stdillum-F5", 0.3138, 0.3452},    {"stdillum-F6", 0.3779, 0.3882},
      {"stdillum-F7", 0.3129, 0.3292},    {"stdillum-F8", 0.3458, 0.3586},    {"stdillum-F9", 0.3741, 0.3727},
      {"stdillum-F10", 0.3458, 0.3588},   {"stdillum-F11", 0.3805, 0.3769},   {"stdillum-F12", 0.4370, 0.4042},
      {"illum-acesD60", 0.32168, 0.33767}};
  for (const Illuminant& illuminant : kIlluminants) {
    if (illuminant.name == name) {
      return rgb_from_xyz(illuminant.x / illuminant.y, 1, (1 - illuminant.x - illuminant.y) / illuminant.y);
    }
  }
  return std::nullopt;
}

SampledSpectrum parse_spd(std::string_view text, const std::string& file) {
  std::vector<double> numbers;
  int last_line = 1;
  text = without_byte_order_mark(text);
  for (int number = 1; !text.empty(); ++number) {
    std::string_view line = take_line(text);
    for (;;) {
      line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
      if (line.empty() || line.front() == '#') break;
      double value = 0;
      if (!take_number(line, value) || !std::isfinite(value)) {
        throw Error({file, number, 0}, "expected a number", "An .spd file holds pairs of wavelength (nm) and value.");
      }
      last_line = number;
      numbers.push_back(value);
    }
  }
  SampledSpectrum spectrum;
  if (numbers.empty() || numbers.size() % 2 != 0) {
    throw Error({file, last_line, 0}, "a wavelength without a value", "Give pairs of wavelength (nm) and value.");
  }
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    if (i > 0 && numbers[i] <= spectrum.wavelengths.back()) {
      throw Error({file}, "the wavelengths do not ascend", "Sort the pairs by wavelength, each wavelength once.");
    }
    spectrum.wavelengths.push_back(numbers[i]);
    spectrum.values.push_back(numbers[i + 1]);
  }
  return spectrum;
}

}  // namespace glowworm
