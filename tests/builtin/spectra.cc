#include "builtin/spectra.h"

#include <cmath>

namespace glowworm {

const CornellSpectrum kCornellWhite = {
    0.343, 0.445, 0.551, 0.624, 0.665, 0.687, 0.708, 0.723, 0.715, 0.710, 0.745, 0.758, 0.739, 0.767, 0.777, 0.765,
    0.751, 0.745, 0.748, 0.729, 0.745, 0.757, 0.753, 0.750, 0.746, 0.747, 0.735, 0.732, 0.739, 0.734, 0.725, 0.721,
    0.733, 0.725, 0.732, 0.743, 0.744, 0.748, 0.728, 0.716, 0.733, 0.726, 0.713, 0.740, 0.754, 0.764, 0.752, 0.736,
    0.734, 0.741, 0.740, 0.732, 0.745, 0.755, 0.751, 0.744, 0.731, 0.733, 0.744, 0.731, 0.712, 0.708, 0.729, 0.730,
    0.727, 0.707, 0.703, 0.729, 0.750, 0.760, 0.751, 0.739, 0.724, 0.730, 0.740, 0.737};
const CornellSpectrum kCornellGreen = {
    0.092, 0.096, 0.098, 0.097, 0.098, 0.095, 0.095, 0.097, 0.095, 0.094, 0.097, 0.098, 0.096, 0.101, 0.103, 0.104,
    0.107, 0.109, 0.112, 0.115, 0.125, 0.140, 0.160, 0.187, 0.229, 0.285, 0.343, 0.390, 0.435, 0.464, 0.472, 0.476,
    0.481, 0.462, 0.447, 0.441, 0.426, 0.406, 0.373, 0.347, 0.337, 0.314, 0.285, 0.277, 0.266, 0.250, 0.230, 0.207,
    0.186, 0.171, 0.160, 0.148, 0.141, 0.136, 0.130, 0.126, 0.123, 0.121, 0.122, 0.119, 0.114, 0.115, 0.117, 0.117,
    0.118, 0.120, 0.122, 0.128, 0.132, 0.139, 0.144, 0.146, 0.150, 0.152, 0.157, 0.159};
const CornellSpectrum kCornellRed = {
    0.040, 0.046, 0.048, 0.053, 0.049, 0.050, 0.053, 0.055, 0.057, 0.056, 0.059, 0.057, 0.061, 0.061, 0.060, 0.062,
    0.062, 0.062, 0.061, 0.062, 0.060, 0.059, 0.057, 0.058, 0.058, 0.058, 0.056, 0.055, 0.056, 0.059, 0.057, 0.055,
    0.059, 0.059, 0.058, 0.059, 0.061, 0.061, 0.063, 0.063, 0.067, 0.068, 0.072, 0.080, 0.090, 0.099, 0.124, 0.154,
    0.192, 0.255, 0.287, 0.349, 0.402, 0.443, 0.487, 0.513, 0.558, 0.584, 0.620, 0.606, 0.609, 0.651, 0.612, 0.610,
    0.650, 0.638, 0.627, 0.620, 0.630, 0.628, 0.642, 0.639, 0.657, 0.639, 0.635, 0.642};

CornellSpectrum cornell_light() {
  constexpr double kWavelength[] = {400, 500, 600, 700}, kRadiance[] = {0, 8, 15.6, 18.4};
  CornellSpectrum light{};
  for (std::size_t i = 0; i < light.size(); ++i) {
    const double wavelength = kCornellFirstWavelength + kCornellWavelengthStep * static_cast<double>(i);
    const std::size_t piece = wavelength < 500 ? 0 : wavelength < 600 ? 1 : 2;
    const double t = (wavelength - kWavelength[piece]) / (kWavelength[piece + 1] - kWavelength[piece]);
    light[i] = kRadiance[piece] * (1 - t) + kRadiance[piece + 1] * t;
  }
  return light;
}

namespace {

// A Gaussian lobe whose inverse widths (1/nm) differ below and above its peak.
double lobe(double wavelength, double peak, double below, double above) {
  const double t = (wavelength - peak) * (wavelength < peak ? below : above);
  return std::exp(-0.5 * t * t);
}

struct Matching {
  double x, y, z;
};

Matching cie_1931(double wavelength) {
  return {0.362 * lobe(wavelength, 442.0, 0.0624, 0.0374) + 1.056 * lobe(wavelength, 599.8, 0.0264, 0.0323) -
              0.065 * lobe(wavelength, 501.1, 0.0490, 0.0382),
          0.821 * lobe(wavelength, 568.8, 0.0213, 0.0247) + 0.286 * lobe(wavelength, 530.9, 0.0613, 0.0322),
          1.217 * lobe(wavelength, 437.0, 0.0845, 0.0278) + 0.681 * lobe(wavelength, 459.0, 0.0385, 0.0725)};
}

}  // namespace

RGB cornell_color(const CornellSpectrum& spectrum) {
  double x = 0, y = 0, z = 0, white = 0;
  for (std::size_t i = 0; i < spectrum.size(); ++i) {
    const Matching m = cie_1931(kCornellFirstWavelength + kCornellWavelengthStep * static_cast<double>(i));
    x += m.x * spectrum[i];
    y += m.y * spectrum[i];
    z += m.z * spectrum[i];
    white += m.y;
  }
  x /= white, y /= white, z /= white;
  return {static_cast<float>(3.2406 * x - 1.5372 * y - 0.4986 * z),
          static_cast<float>(-0.9689 * x + 1.8758 * y + 0.0415 * z),
          static_cast<float>(0.0557 * x - 0.2040 * y + 1.0570 * z)};
}

RGB cornell_reflectance(const CornellSpectrum& reflectance) {
  const CornellSpectrum light = cornell_light();
  CornellSpectrum reflected = light;
  for (std::size_t i = 0; i < light.size(); ++i) reflected[i] *= reflectance[i];
  return cornell_color(reflected) / cornell_color(light);
}

}  // namespace glowworm
