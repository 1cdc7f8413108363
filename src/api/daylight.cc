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
#include "measure/view_year.h"
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

/// What is read before any scene.
struct YearInputs {
  RenderSettings asked;
  MetricLimits limits;
  std::vector<Daylight::Hour> hours;
  YearModel model;
  std::vector<std::uint8_t> occupied;
};

YearInputs read_inputs(const DaylightOptions& o, const std::string& path) {
  const RenderSettings asked = settings_of(o.render, Command::measure);
  check_year_settings(asked);
  const MetricLimits limits = limits_of(o);
  const WeatherYear weather = parse_weather_year(read_input_file(path), path, o.turn);
  for (const std::string& note : weather.notes) warn(path + ": " + note);
  YearInputs out{asked, limits, {}, YearModel(weather, path, o.sky_patches, o.ground, o.sun_step), {}};
  out.occupied = occupied_of(o, weather.hours);
  check_shades(o, weather.hours.size());
  for (const WeatherHour& hour : weather.hours) out.hours.push_back({hour.moment.month, hour.moment.day, hour.hour});
  return out;
}

/// Follows the work on one of the states of a scene. @param state 0 for the scene itself
YearWatch watch_of(const DaylightOptions& o, std::size_t state, const std::function<void(double)>& progress) {
  if (!progress) return {[&](Job& job, YearProgress) { attend(job, progress); }, nullptr};
  const auto states = static_cast<double>(o.shades.size() + 1);
  const auto told = [=, &progress](double share) { progress((static_cast<double>(state) + share) / states); };
  return {
      [=](Job& job, YearProgress part) { attend(job, [&](double share) { told(part.before + part.share * share); }); },
      told};
}

std::vector<glowworm::Camera> cameras_of(std::span<const Camera> views, const glowworm::Scene& scene) {
  std::vector<glowworm::Camera> out;
  for (const Camera& view : views) {
    const bool is_rated =
        view.projection == Camera::Projection::fisheye || view.projection == Camera::Projection::hemispherical;
    if (!is_rated || view.field_of_view != 180)
      throw Error("camera '" + view.name + "' does not show the half space before an eye",
                  "Give a fisheye or hemispherical camera with a field_of_view of 180.");
    out.push_back(inner(view));
    out.back().to_world.translation = scene.inside(out.back().to_world.translation);
  }
  return out;
}

}  // namespace

std::vector<std::string> daylight_option_names() { return option_names(Command::measure); }

Daylight daylight(const Scene& scene, const std::string& weather_path, std::span<const Vec3> position,
                  std::span<const Vec3> normal, const DaylightOptions& o, const std::function<void(double)>& progress) {
  YearInputs inputs = read_inputs(o, weather_path);
  const YearModel& model = inputs.model;
  const RenderSettings& asked = inputs.asked;
  const std::vector<float> area = area_of(o, position.size());
  check_year_room(position.size(), inputs.hours.size(), 1 + o.shades.size(),
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
    std::optional<FoundState> found = find_state(*plain, sky, moved_sensors(sensors, *first, *plain), o.on_surfaces,
                                                 model, asked, watch_of(o, i, progress));
    if (!found) throw Cancelled();
    if (i == 0) out.relative_error = std::move(found->relative_error);
    states.push_back(std::move(found->state));
  }
  Year year = year_of(model.sky, model.suns, states, o.shade_of_hour);
  add_metrics(year, inputs.occupied, inputs.limits, area, out);
  out.daylight_factor = share_under(states.front().coefficients, overcast_sky(model.patches, model.ground));
  out.hours = std::move(inputs.hours);
  out.illuminance = std::move(year.total);
  out.sun = std::move(year.sun);
  return out;
}

AnnualGlare annual_glare(const Scene& scene, const std::string& weather_path, std::span<const Camera> views,
                         const DaylightOptions& o, const std::function<void(double)>& progress) {
  if (views.empty()) throw Error("there are no views to rate");
  if (o.view_pixels < 16 || o.view_pixels > 1024)
    throw Error(fmt::format("view_pixels is {}, and not from 16 to 1024", o.view_pixels));
  YearInputs inputs = read_inputs(o, weather_path);
  std::vector<ViewYear> rated(views.size(), ViewYear(inputs.hours.size()));
  for (std::size_t i = 0; i <= o.shades.size(); ++i) {
    const auto plain = lit_by_its_own((i == 0 ? scene : o.shades[i - 1]).implementation().scene);
    if (!rate_views(*plain, cameras_of(views, *plain), static_cast<std::uint32_t>(o.view_pixels), inputs.model,
                    hours_of_state(inputs.model.sky, o.shade_of_hour, i), inputs.asked, watch_of(o, i, progress),
                    rated))
      throw Cancelled();
  }
  AnnualGlare out{std::move(inputs.hours), {}};
  for (ViewYear& view : rated) {
    const GlareMetrics m = glare_metrics(view.dgp, inputs.occupied);
    out.views.push_back({std::move(view.dgp), std::move(view.illuminance), std::move(view.dgp_error),
                         std::move(view.illuminance_error), m.exceeded, m.hours_above[0], m.hours_above[1],
                         m.hours_above[2]});
  }
  return out;
}

}  // namespace glowworm::api
