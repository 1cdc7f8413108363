#include "import/daylight.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "scene/sky_model.h"

namespace glowworm {

namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kSolarConstant = 1367;   // W m^-2, as the model's authors take it
constexpr double kPrecipitableWater = 2;  // cm, where none is measured
constexpr double kTwilight = -6;          // degrees: civil twilight, when the sky gives light without the sun
/// The range of the model, as in Radiance's gendaylit. Beyond it, as with a bright sky and the sun on the horizon, the
/// formula may give no light at all.
constexpr double kMinBrightness = 0.01, kMaxBrightness = 0.6, kGreatestClearness = 11.9;

/// Bins of the sky's clearness (Perez et al. 1990, table 1).
constexpr std::array<double, 7> kClearness = {1.065, 1.230, 1.500, 1.950, 2.800, 4.500, 6.200};

/// Perez et al. 1993, table 1: for each bin the coefficients of a, b, c, d and e.
constexpr double kSky[8][5][4] = {
    {{1.3525, -0.2576, -0.2690, -1.4366},
     {-0.7670, 0.0007, 1.2734, -0.1233},
     {2.8000, 0.6004, 1.2375, 1.0000},
     {1.8734, 0.6297, 0.9738, 0.2809},
     {0.0356, -0.1246, -0.5718, 0.9938}},
    {{-1.2219, -0.7730, 1.4148, 1.1016},
     {-0.2054, 0.0367, -3.9128, 0.9156},
     {6.9750, 0.1774, 6.4477, -0.1239},
     {-1.5798, -0.5081, -1.7812, 0.1080},
     {0.2624, 0.0672, -0.2190, -0.4285}},
    {{-1.1000, -0.2515, 0.8952, 0.0156},
     {0.2782, -0.1812, -4.5000, 1.1766},
     {24.7219, -13.0812, -37.7000, 34.8438},
     {-5.0000, 1.5218, 3.9229, -2.6204},
     {-0.0156, 0.1597, 0.4199, -0.5562}},
    {{-0.5484, -0.6654, -0.2672, 0.7117},
     {0.7234, -0.6219, -5.6812, 2.6297},
     {33.3389, -18.3000, -62.2500, 52.0781},
     {-3.5000, 0.0016, 1.1477, 0.1062},
     {0.4659, -0.3296, -0.0876, -0.0329}},
    {{-0.6000, -0.3566, -2.5000, 2.3250},
     {0.2937, 0.0496, -5.6812, 1.8415},
     {21.0000, -4.7656, -21.5906, 7.2492},
     {-3.5000, -0.1554, 1.4062, 0.3988},
     {0.0032, 0.0766, -0.0656, -0.1294}},
    {{-1.0156, -0.3670, 1.0078, 1.4051},
     {0.2875, -0.5328, -3.8500, 3.3750},
     {14.0000, -0.9999, -7.1406, 7.5469},
     {-3.4000, -0.1078, -1.0750, 1.5702},
     {-0.0672, 0.4016, 0.3017, -0.4844}},
    {{-1.0000, 0.0211, 0.5025, -0.5119},
     {-0.3000, 0.1922, 0.7023, -1.6317},
     {19.0000, -5.0000, 1.2438, -1.9094},
     {-4.0000, 0.0250, 0.3844, 0.2656},
     {1.0468, -0.3788, -2.4517, 1.4656}},
    {{-1.0500, 0.0289, 0.4260, 0.3590},
     {-0.3250, 0.1156, 0.7781, 0.0025},
     {31.0625, -14.5000, -46.1148, 55.3750},
     {-7.2312, 0.4050, 13.3500, 0.6234},
     {1.5000, -0.6426, 1.8564, 0.5636}},
};

/// Perez et al. 1990, table 4: luminous efficacy in lm/W of diffuse and of direct light.
constexpr double kDiffuseEfficacy[8][4] = {
    {97.24, -0.46, 12.00, -8.91},   {107.22, 1.15, 0.59, -3.95},    {104.97, 2.96, -5.53, -8.77},
    {102.39, 5.59, -13.95, -13.90}, {100.71, 5.94, -22.75, -23.74}, {106.42, 3.83, -36.15, -28.83},
    {141.88, 1.90, -53.24, -14.03}, {152.23, 0.35, -45.27, -7.98},
};
constexpr double kDirectEfficacy[8][4] = {
    {57.20, -4.55, -2.98, 117.12}, {98.99, -3.46, -1.21, 12.38},  {109.83, -4.90, -1.71, -8.81},
    {110.34, -5.84, -1.99, -4.56}, {106.36, -3.97, -1.75, -6.16}, {107.19, -1.25, -1.51, -26.73},
    {105.75, 0.77, -1.26, -34.44}, {101.18, 1.58, -1.10, -8.29},
};

int day_of_year(int month, int day) {
  constexpr int kBefore[12] = {0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334};
  return kBefore[std::clamp(month, 1, 12) - 1] + day;
}

/// Parameters that the model derives from the measured irradiance.
struct Indices {
  double zenith;  ///< of the sun, radians
  double clearness, brightness;
  std::size_t bin;
};

Indices indices_of(const SkyMoment& moment, const SunPlace& sun, const SolarIrradiance& e) {
  Indices out{};
  out.zenith = (90 - sun.altitude) * kDegree;
  const double cubed = 1.041 * out.zenith * out.zenith * out.zenith;
  out.clearness = ((e.diffuse_horizontal + e.direct_normal) / e.diffuse_horizontal + cubed) / (1 + cubed);
  out.clearness = std::clamp(out.clearness, 1.0, kGreatestClearness);
  // Air mass: Kasten and Young, Applied Optics 28(22), 1989.
  const double mass = 1 / (std::cos(out.zenith) + 0.50572 * std::pow(96.07995 - out.zenith / kDegree, -1.6364));
  const double day = 2 * M_PI * day_of_year(moment.month, moment.day) / 365;
  const double eccentricity = 1.00011 + 0.034221 * std::cos(day) + 0.00128 * std::sin(day) +
                              0.000719 * std::cos(2 * day) + 0.000077 * std::sin(2 * day);
  out.brightness =
      std::clamp(e.diffuse_horizontal * mass / (kSolarConstant * eccentricity), kMinBrightness, kMaxBrightness);
  out.bin = static_cast<std::size_t>(std::upper_bound(kClearness.begin(), kClearness.end(), out.clearness) -
                                     kClearness.begin());
  return out;
}

/// The five numbers of the sky's formula.
std::array<double, 5> coefficients_of(const Indices& i) {
  // The authors' correction for bins of intermediate skies.
  const bool intermediate = i.clearness > 1.065 && i.clearness < 2.8;
  const double delta = intermediate ? std::max(i.brightness, 0.2) : i.brightness, z = i.zenith;
  std::array<double, 5> out;
  const auto& x = kSky[i.bin];
  for (std::size_t k = 0; k < 5; ++k) out[k] = x[k][0] + x[k][1] * z + delta * (x[k][2] + x[k][3] * z);
  if (i.bin == 0) {
    out[2] = std::exp(std::pow(delta * (x[2][0] + x[2][1] * z), x[2][2])) - x[2][3];
    out[3] = -std::exp(delta * (x[3][0] + x[3][1] * z)) + x[3][2] + delta * x[3][3];
  }
  return out;
}

}  // namespace

SunPlace sun_place(const SkyMoment& m) {
  const double day = day_of_year(m.month, m.day);
  const double solar_hour = m.hour + 0.170 * std::sin(4 * M_PI / 373 * (day - 80)) -
                            0.129 * std::sin(2 * M_PI / 355 * (day - 8)) + (m.longitude - 15 * m.zone) / 15;
  const double declination = 0.4093 * std::sin(2 * M_PI / 368 * (day - 81));
  const double latitude = m.latitude * kDegree, turn = solar_hour * M_PI / 12;
  const double up =
      std::sin(latitude) * std::sin(declination) - std::cos(latitude) * std::cos(declination) * std::cos(turn);
  const double east = std::cos(declination) * std::sin(turn);
  const double north =
      std::cos(latitude) * std::sin(declination) + std::sin(latitude) * std::cos(declination) * std::cos(turn);
  double azimuth = std::atan2(east, north) / kDegree;
  if (azimuth < 0) azimuth += 360;
  return {std::asin(std::clamp(up, -1.0, 1.0)) / kDegree, azimuth};
}

std::optional<PerezSky> perez_sky(const SkyMoment& moment, const SolarIrradiance& e) {
  SunPlace sun = sun_place(moment);
  if (!(sun.altitude > kTwilight) || !(e.diffuse_horizontal > 0 || e.direct_normal > 0)) return std::nullopt;
  const bool is_up = sun.altitude > 0;
  sun.altitude = std::max(sun.altitude, 0.0);
  const Indices indices = indices_of(moment, sun, e);
  const std::array<double, 5> k = coefficients_of(indices);
  const auto& diffuse = kDiffuseEfficacy[indices.bin];
  const auto& direct = kDirectEfficacy[indices.bin];
  const double of_sky = diffuse[0] + diffuse[1] * kPrecipitableWater + diffuse[2] * std::cos(indices.zenith) +
                        diffuse[3] * std::log(indices.brightness);
  const double of_sun = std::max(direct[0] + direct[1] * kPrecipitableWater +
                                     direct[2] * std::exp(5.73 * indices.zenith - 5) + direct[3] * indices.brightness,
                                 0.0);
  PerezSky out;
  SkyModel& sky = out.shape;
  sky.a = static_cast<float>(k[0]), sky.b = static_cast<float>(std::min(k[1], 0.0)), sky.c = static_cast<float>(k[2]);
  sky.d = static_cast<float>(k[3]), sky.e = static_cast<float>(k[4]);
  sky.sun = sky_direction(static_cast<float>(sun.altitude), static_cast<float>(sun.azimuth - moment.turn));
  out.diffuse = e.diffuse_horizontal * of_sky / kLuminousEfficacy;
  out.direct = is_up ? e.direct_normal * of_sun / kLuminousEfficacy : 0;
  return out;
}

void add_perez_sky(const SkyMoment& moment, const SolarIrradiance& e, double ground, SceneDescription& scene) {
  const double altitude = sun_place(moment).altitude;
  if (!(altitude > kTwilight))
    throw Error(fmt::format("the sun is {:.1f} degrees below the horizon at {:02}-{:02}, {:g} h", -altitude,
                            moment.month, moment.day, moment.hour),
                "Give an hour of the day.");
  const std::optional<PerezSky> found = perez_sky(moment, e);
  if (!found) throw Error("neither the sky nor the sun has any irradiance", "Give more than 0 W m^-2 of one of them.");
  SkyModel sky = found->shape;
  sky.zenith = static_cast<float>(found->diffuse / horizontal_irradiance(sky));
  sky.ground = static_cast<float>(ground * found->horizontal() / M_PI);
  scene.environment = sky_environment(sky);
  if (!(found->direct > 0)) return;
  Light light;
  light.name = "sun";
  light.kind = LightKind::directional;
  light.intensity = RGB(static_cast<float>(found->direct));
  light.direction = -sky.sun;
  scene.lights.push_back(light);
}

}  // namespace glowworm
