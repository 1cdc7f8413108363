// The public header glowworm/daylight.h.
#include "glowworm/daylight.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "api/run_job.h"
#include "api/scene_implementation.h"
#include "api/sensor_input.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"
#include "measure/annual_metrics.h"
#include "measure/doubts.h"
#include "measure/find_year.h"
#include "settings/options.h"

namespace glowworm::api {

namespace {

/// Metrics by sensor, and of all of them.
void add_metrics(const Year& year, std::span<const std::uint8_t> occupied, const MetricLimits& limits,
                 std::span<const float> area, Daylight& out) {
  const std::vector<SensorMetrics> metrics = metrics_of(year, occupied, limits);
  const auto add = [](std::vector<float>& to, double value) { to.push_back(static_cast<float>(value)); };
  for (const SensorMetrics& m : metrics) {
    add(out.mean, m.mean);
    add(out.autonomy, m.autonomy);
    add(out.continuous, m.continuous);
    for (const double share : m.useful) add(out.useful, share);
    add(out.sun_hours, m.sun_hours);
    add(out.glare, m.glare);
  }
  std::vector<std::uint32_t> all(metrics.size());
  std::iota(all.begin(), all.end(), 0u);
  const ZoneMetrics zone = metrics_of_zone(metrics, all, area, limits);
  out.spatial_autonomy = zone.spatial_autonomy;
  out.sun_exposure = zone.sun_exposure;
}

MetricLimits limits_of(const DaylightOptions& o) {
  const MetricLimits limits{o.autonomy_lux, MetricLimits().autonomy_share, o.sun_lux, o.sun_hours, o.useful, o.glare};
  if (!limits.are_sound()) throw Error("the limits of useful illuminance do not rise", "Give lx: 100, 300, 3000.");
  const auto check = [](double value, double least, double most, const char* name) {
    if (!(value >= least && value <= most))
      throw Error(fmt::format("{} is {}, and not from {} to {}", name, value, least, most));
  };
  check(o.sun_step, 2, 30, "sun_step");
  check(o.ground, 0, 1, "ground");
  check(o.autonomy_lux, 1, 1e6, "autonomy_lux");
  check(o.sun_lux, 1, 1e6, "sun_lux");
  check(o.sun_hours, 0, 8784, "sun_hours");
  check(o.glare, 0, 1, "glare");
  return limits;
}

std::vector<std::uint8_t> occupied_of(const DaylightOptions& o, std::span<const WeatherHour> hours) {
  if (o.occupied.empty()) return occupied_hours(o.hours, hours);
  if (o.occupied.size() != hours.size())
    throw Error("`occupied` has " + std::to_string(o.occupied.size()) + " hours, and the weather file " +
                std::to_string(hours.size()));
  if (std::any_of(o.occupied.begin(), o.occupied.end(), [](std::uint8_t hour) { return hour > 1; }))
    throw Error("`occupied` has numbers other than 0 and 1");
  return o.occupied;
}

void check_shades(const DaylightOptions& o, std::size_t hours) {
  if (o.shades.empty() && o.shade_of_hour.empty()) return;
  if (o.shade_of_hour.size() != hours)
    throw Error("shade_of_hour has " + std::to_string(o.shade_of_hour.size()) + " hours, and the weather file " +
                std::to_string(hours));
  if (*std::max_element(o.shade_of_hour.begin(), o.shade_of_hour.end()) > o.shades.size())
    throw Error("shade_of_hour names a scene beyond the " + std::to_string(o.shades.size()) + " of `shades`");
}

std::vector<float> area_of(const DaylightOptions& o, std::size_t sensors) {
  if (o.area.empty()) return std::vector<float>(sensors, 1.0f);
  if (o.area.size() != sensors ||
      !std::all_of(o.area.begin(), o.area.end(), [](float a) { return a > 0 && a < 1e30f; }))
    throw Error("`area` does not have a positive number for each sensor");
  return o.area;
}

}  // namespace

std::vector<std::string> daylight_option_names() { return option_names(Command::measure); }

Daylight daylight(const Scene& scene, const std::string& weather_path, std::span<const Vec3> position,
                  std::span<const Vec3> normal, const DaylightOptions& o, const std::function<void(double)>& progress) {
  RenderSettings asked = settings_of(o.render, Command::measure);
  check_year_settings(asked);
  const MetricLimits limits = limits_of(o);
  const WeatherYear weather = parse_weather_year(read_input_file(weather_path), weather_path);
  for (const std::string& note : weather.notes) warn(weather_path + ": " + note);
  const YearModel model(weather, weather_path, o.sky_patches, o.ground, o.sun_step);
  const std::vector<std::uint8_t> occupied = occupied_of(o, weather.hours);
  check_shades(o, weather.hours.size());
  const std::vector<float> area = area_of(o, position.size());
  check_year_room(position.size(), weather.hours.size(), 1 + o.shades.size(),
                  asked.memory_bytes > 0 ? asked.memory_bytes : default_memory_bytes());
  std::vector<YearState> states;
  Daylight out;
  Sensors sensors;
  std::shared_ptr<const glowworm::Scene> first;
  for (std::size_t i = 0; i <= o.shades.size(); ++i) {
    const Scene& state = i == 0 ? scene : o.shades[i - 1];
    const auto plain = lit_by_its_own(state.implementation().scene);
    const YearScene sky = under_sky(*plain, model);
    if (i == 0) {
      first = plain;
      sensors = sensors_of(position, normal, *sky.tracer, o.on_surfaces);
    }
    const double each = 1.0 / static_cast<double>(o.shades.size() + 1);
    const auto wait = [&](Job& job, YearProgress part) {
      attend(
          job, !progress ? progress : [&](double share) {
            progress((static_cast<double>(i) + part.before + part.share * share) * each);
          });
    };
    std::optional<FoundState> found =
        find_state(*plain, sky, moved_sensors(sensors, *first, *plain), o.on_surfaces, model, asked, wait);
    if (!found) throw Cancelled();
    if (i == 0) out.relative_error = std::move(found->relative_error);
    states.push_back(std::move(found->state));
  }
  Year year = year_of(model.sky, model.suns, states, o.shade_of_hour);
  add_metrics(year, occupied, limits, area, out);
  out.daylight_factor = share_under(states.front().coefficients, overcast_sky(model.patches, model.ground));
  for (const WeatherHour& hour : weather.hours) out.hours.push_back({hour.moment.month, hour.moment.day, hour.hour});
  out.illuminance = std::move(year.total);
  out.sun = std::move(year.sun);
  return out;
}

}  // namespace glowworm::api
