#include "import/sky_text.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/input_file.h"
#include "core/text.h"
#include "import/daylight.h"
#include "import/weather.h"
#include "scene/sky_model.h"

namespace glowworm {

namespace {

constexpr std::string_view kCie = "cie:", kPerez = "perez:", kWeather = "epw:";

[[noreturn]] void refuse(const std::string& text) {
  throw Error(fmt::format("--sky '{}' names no sky", text),
              "Write cie:TYPE[,ALTITUDE,AZIMUTH[,LUX[,GROUND]]], for example cie:16 (overcast) or cie:12,50,135,30000; "
              "perez:DIRECT,DIFFUSE,MONTH,DAY,HOUR,LATITUDE,LONGITUDE,ZONE[,GROUND] with W m^-2, for example "
              "perez:600,120,6,21,10.5,52.5,13.4,1; or epw:FILE,MONTH,DAY,HOUR[,GROUND] with an hour from 1 to 24.");
}

struct CieText {
  int type = 0;
  double altitude = 45, azimuth = 180, lux = 10'000, ground = 0.2;
};

CieText read_cie(const std::string& text) {
  const std::vector<double> v = numbers_of<double>(std::string_view(text).substr(kCie.size()));
  if ((v.size() != 1 && v.size() < 3) || v.size() > 5) refuse(text);
  CieText out;
  out.type = v[0] >= 1 && v[0] <= 16 && v[0] == std::floor(v[0]) ? static_cast<int>(v[0]) : 0;
  if (v.size() > 2) out.altitude = v[1], out.azimuth = v[2];
  if (v.size() > 3) out.lux = v[3];
  if (v.size() > 4) out.ground = v[4];
  const bool good = out.type > 0 && out.altitude >= 0 && out.altitude <= 90 && std::abs(out.azimuth) <= 360 &&
                    out.lux >= 0 && out.lux <= 1e6 && out.ground >= 0 && out.ground <= 1;
  if (!good) refuse(text);
  return out;
}

bool is_date(double month, double day) {
  return month >= 1 && month <= 12 && day >= 1 && day <= 31 && month == std::floor(month) && day == std::floor(day);
}

struct PerezText {
  SkyMoment moment;
  SolarIrradiance irradiance;
  double ground = 0.2;
};

PerezText read_perez(const std::string& text) {
  const std::vector<double> v = numbers_of<double>(std::string_view(text).substr(kPerez.size()));
  if (v.size() != 8 && v.size() != 9) refuse(text);
  PerezText out{{static_cast<int>(v[2]), static_cast<int>(v[3]), v[4], v[5], v[6], v[7]}, {v[0], v[1]}};
  if (v.size() > 8) out.ground = v[8];
  const bool good = v[0] >= 0 && v[0] <= 1500 && v[1] >= 0 && v[1] <= 1500 && is_date(v[2], v[3]) && v[4] >= 0 &&
                    v[4] <= 24 && std::abs(v[5]) <= 90 && std::abs(v[6]) <= 180 && std::abs(v[7]) <= 14 &&
                    out.ground >= 0 && out.ground <= 1;
  if (!good) refuse(text);
  return out;
}

struct WeatherText {
  std::string file;
  int month = 0, day = 0, hour = 0;
  double ground = 0.2;
};

WeatherText read_weather(const std::string& text) {
  // The file's name may hold commas: three or four numbers stand behind it.
  const std::string_view rest = std::string_view(text).substr(kWeather.size());
  for (const int count : {4, 3}) {
    std::size_t comma = rest.size();
    for (int i = 0; i < count && comma != std::string_view::npos && comma > 0; ++i) comma = rest.rfind(',', comma - 1);
    if (comma == std::string_view::npos || comma == 0) continue;
    const std::vector<double> v = numbers_of<double>(rest.substr(comma + 1));
    if (v.size() != static_cast<std::size_t>(count) || !is_date(v[0], v[1]) || !(v[2] >= 1 && v[2] <= 24)) continue;
    WeatherText out{std::string(rest.substr(0, comma)), static_cast<int>(v[0]), static_cast<int>(v[1]),
                    static_cast<int>(v[2])};
    if (count == 4) out.ground = v[3];
    if (v[2] == std::floor(v[2]) && out.ground >= 0 && out.ground <= 1) return out;
  }
  refuse(text);
}

}  // namespace

void check_sky(const std::string& text) {
  if (text.starts_with(kCie))
    read_cie(text);
  else if (text.starts_with(kPerez))
    read_perez(text);
  else if (text.starts_with(kWeather))
    read_weather(text);
  else
    refuse(text);
}

void add_sky(const std::string& text, double turn, SceneDescription& scene) {
  check_sky(text);
  if (text.starts_with(kPerez)) {
    PerezText t = read_perez(text);
    t.moment.turn = turn;
    return add_perez_sky(t.moment, t.irradiance, t.ground, scene);
  }
  if (text.starts_with(kWeather)) {
    const WeatherText t = read_weather(text);
    WeatherHour hour = parse_weather_hour(read_input_file(t.file), t.file, t.month, t.day, t.hour);
    hour.moment.turn = turn;
    return add_perez_sky(hour.moment, hour.irradiance, t.ground, scene);
  }
  const CieText t = read_cie(text);
  const Vec3 sun = sky_direction(static_cast<float>(t.altitude), static_cast<float>(t.azimuth - turn));
  scene.environment = sky_environment(cie_sky(t.type, sun, t.lux / kLuminousEfficacy, t.ground));
}

}  // namespace glowworm
