#include "builtin/sky.h"

#include <algorithm>

namespace glowworm {

namespace {

// Perez' five parameters: distribution of luminance or of one chromaticity coordinate over the sky.
struct Perez {
  double a, b, c, d, e;
  double operator()(double cos_theta, double gamma) const {
    const double cos_gamma = std::cos(gamma);
    return (1 + a * std::exp(b / cos_theta)) * (1 + c * std::exp(d * gamma) + e * cos_gamma * cos_gamma);
  }
};

double zenith_chromaticity(const double (&m)[3][4], double turbidity, double sun) {
  double sum = 0;
  for (int row = 0; row < 3; ++row) {
    const double t = row == 0 ? turbidity * turbidity : row == 1 ? turbidity : 1;
    sum += t * (((m[row][0] * sun + m[row][1]) * sun + m[row][2]) * sun + m[row][3]);
  }
  return sum;
}

constexpr double kZenithX[3][4] = {
    {0.00166, -0.00375, 0.00209, 0}, {-0.02903, 0.06377, -0.03202, 0.00394}, {0.11693, -0.21196, 0.06052, 0.25886}};
constexpr double kZenithY[3][4] = {
    {0.00275, -0.00610, 0.00317, 0}, {-0.04214, 0.08970, -0.04153, 0.00516}, {0.15346, -0.26756, 0.06670, 0.26688}};

}  // namespace

RGB clear_sky_radiance(Vec3 direction, Vec3 to_sun, float turbidity) {
  const double t = turbidity;
  const Perez luminance{0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771,
                        -0.0670 * t + 0.3703};
  const Perez chroma_x{-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989,
                       -0.0033 * t + 0.0452};
  const Perez chroma_y{-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
                       -0.0109 * t + 0.0529};
  const double pi = 3.14159265358979323846;
  const double sun = std::acos(std::clamp(static_cast<double>(to_sun.y), 0.0, 1.0));
  const double cos_theta = std::max(static_cast<double>(direction.y), 0.01);  // the formula diverges at the horizon
  const double gamma = std::acos(std::clamp(static_cast<double>(dot(direction, to_sun)), -1.0, 1.0));
  const double zenith = (4.0453 * t - 4.9710) * std::tan((4.0 / 9 - t / 120) * (pi - 2 * sun)) - 0.2155 * t + 2.4192;

  const double y_luminance = zenith * luminance(cos_theta, gamma) / luminance(1, sun);  // kcd/m^2
  const double x = zenith_chromaticity(kZenithX, t, sun) * chroma_x(cos_theta, gamma) / chroma_x(1, sun);
  const double y = zenith_chromaticity(kZenithY, t, sun) * chroma_y(cos_theta, gamma) / chroma_y(1, sun);
  const double big_y = y_luminance / 10, big_x = big_y * x / y, big_z = big_y * (1 - x - y) / y;
  // XYZ to linear Rec. 709 by IEC 61966-2-1.
  const RGB color{static_cast<float>(3.2406 * big_x - 1.5372 * big_y - 0.4986 * big_z),
                  static_cast<float>(-0.9689 * big_x + 1.8758 * big_y + 0.0415 * big_z),
                  static_cast<float>(0.0557 * big_x - 0.2040 * big_y + 1.0570 * big_z)};
  return {std::max(color.r, 0.0f), std::max(color.g, 0.0f), std::max(color.b, 0.0f)};
}

Environment clear_sky(Vec3 to_sun, float turbidity, int height) {
  Environment sky;
  sky.name = "sky";
  sky.height = height;
  sky.width = 2 * height;
  sky.pixels.resize(static_cast<std::size_t>(sky.width) * static_cast<std::size_t>(height));
  RGB irradiance{0, 0, 0};
  for (int row = 0; row < height / 2; ++row)
    for (int column = 0; column < sky.width; ++column) {
      const float theta = kPi * (static_cast<float>(row) + 0.5f) / static_cast<float>(height);
      const float phi = 2 * kPi * ((static_cast<float>(column) + 0.5f) / static_cast<float>(sky.width) - 0.5f);
      const Vec3 direction{std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
      const RGB radiance = clear_sky_radiance(direction, to_sun, turbidity);
      const float cell = kPi / static_cast<float>(height);  // radians on both sides
      irradiance += radiance * (std::cos(theta) * std::sin(theta) * cell * cell);
      sky.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(sky.width) +
                 static_cast<std::size_t>(column)] = radiance;
    }
  const RGB ground = irradiance * (0.2f * kInversePi);
  std::fill(sky.pixels.begin() + static_cast<std::ptrdiff_t>(sky.pixels.size() / 2), sky.pixels.end(), ground);
  return sky;
}

Light clear_sun(Vec3 to_sun) {
  Light sun;
  sun.name = "sun";
  sun.kind = LightKind::directional;
  // The colour of a black body of 5000 K with luminance 1, close to the sun's through a clear air mass of 1.2.
  const RGB color{1.19f, 0.97f, 0.74f};
  sun.intensity = color * (9 / luminance(color));
  sun.direction = -to_sun;
  return sun;
}

}  // namespace glowworm
