#include "scene/sky_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "scene/light.h"

namespace glowworm {

namespace {

/// Size of the table that directions are sampled by, and parts of a texel's side that its mean is taken over.
constexpr int kTableHeight = 128, kParts = 2;

/// Gradation a, b and indicatrix c, d, e of CIE S 011/E:2003, table 1.
struct CieType {
  float a, b, c, d, e;
};
constexpr CieType kCieTypes[15] = {
    {4, -0.70f, 0, -1, 0},
    {4, -0.70f, 2, -1.5f, 0.15f},
    {1.1f, -0.8f, 0, -1, 0},
    {1.1f, -0.8f, 2, -1.5f, 0.15f},
    {0, -1, 0, -1, 0},
    {0, -1, 2, -1.5f, 0.15f},
    {0, -1, 5, -2.5f, 0.30f},
    {0, -1, 10, -3, 0.45f},
    {-1, -0.55f, 2, -1.5f, 0.15f},
    {-1, -0.55f, 5, -2.5f, 0.30f},
    {-1, -0.55f, 10, -3, 0.45f},
    {-1, -0.32f, 10, -3, 0.45f},
    {-1, -0.32f, 16, -3, 0.30f},
    {-1, -0.15f, 16, -3, 0.30f},
    {-1, -0.15f, 24, -2.8f, 0.15f},
};

}  // namespace

float sky_radiance(const SkyModel& s, Vec3 d) {
  if (!(d.y > 0)) return s.ground;
  const float cosine = std::clamp(dot(d, s.sun), -1.0f, 1.0f);
  // By atan2 of the sine, since acos loses small angles to rounding.
  const float chi = std::atan2(length(cross(d, s.sun)), cosine);
  const float gradation = 1 + s.a * std::exp(s.b / d.y) + s.linear * d.y;
  const float indicatrix = 1 + s.c * (std::exp(s.d * chi) - s.offset) + s.e * cosine * cosine;
  return s.zenith * std::max(gradation * indicatrix, 0.0f);
}

double horizontal_irradiance(const SkyModel& sky) {
  // The midpoint rule over the squared sine of the altitude, whose differential is the cosine-weighted solid angle over
  // pi, and over the azimuth from the sun, where the radiance is the same on both sides.
  constexpr int kRings = 1000, kSteps = 180;
  const double sun_azimuth = std::atan2(sky.sun.x, -sky.sun.z);
  double sum = 0;
  for (int i = 0; i < kRings; ++i) {
    const double squared = (i + 0.5) / kRings, y = std::sqrt(squared), r = std::sqrt(1 - squared);
    for (int j = 0; j < kSteps; ++j) {
      const double azimuth = sun_azimuth + M_PI * (j + 0.5) / kSteps;
      sum += sky_radiance(sky, {static_cast<float>(r * std::sin(azimuth)), static_cast<float>(y),
                                static_cast<float>(-r * std::cos(azimuth))});
    }
  }
  return M_PI * sum / (double{kRings} * kSteps);
}

Vec3 sky_direction(float altitude, float azimuth) {
  const double up = altitude * M_PI / 180, around = azimuth * M_PI / 180;
  return normalize({static_cast<float>(std::cos(up) * std::sin(around)), static_cast<float>(std::sin(up)),
                    static_cast<float>(-std::cos(up) * std::cos(around))});
}

SkyModel cie_sky(int type, Vec3 sun, double irradiance, double ground_reflectance) {
  if (type < 1 || type > 16)
    throw Error(fmt::format("the CIE has no sky of type {}", type),
                "Give 1 to 15 for the standard general skies, or 16 for the traditional overcast sky.");
  SkyModel sky;
  sky.sun = sun;
  if (type == 16) {
    sky.linear = 2;
  } else {
    const CieType& t = kCieTypes[type - 1];
    sky.a = t.a, sky.b = t.b, sky.c = t.c, sky.d = t.d, sky.e = t.e;
    sky.offset = static_cast<float>(std::exp(t.d * M_PI / 2));
  }
  sky.zenith = static_cast<float>(irradiance / horizontal_irradiance(sky));
  sky.ground = static_cast<float>(ground_reflectance * irradiance / M_PI);
  return sky;
}

Environment sky_environment(const SkyModel& sky) {
  Environment e;
  e.name = "sky";
  e.height = kTableHeight;
  e.width = 2 * kTableHeight;
  e.sky = sky;
  e.pixels.reserve(static_cast<std::size_t>(e.width) * e.height);
  for (int y = 0; y < e.height; ++y)
    for (int x = 0; x < e.width; ++x) {
      float sum = 0;
      for (int j = 0; j < kParts; ++j)
        for (int i = 0; i < kParts; ++i) {
          const double theta = (y + (j + 0.5) / kParts) / e.height * M_PI;
          const double phi = ((x + (i + 0.5) / kParts) / e.width - 0.5) * 2 * M_PI;
          sum += sky_radiance(sky,
                              {static_cast<float>(std::sin(theta) * std::sin(phi)), static_cast<float>(std::cos(theta)),
                               static_cast<float>(-std::sin(theta) * std::cos(phi))});
        }
      e.pixels.emplace_back(sum / (kParts * kParts));
    }
  return e;
}

}  // namespace glowworm
