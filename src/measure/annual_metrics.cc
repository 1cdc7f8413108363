#include "measure/annual_metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/error.h"
#include "core/lines.h"
#include "core/parallel.h"
#include "core/text.h"

namespace glowworm {

namespace {

/// Adds a multiple of metrics to their mean.
void add_share(const SensorMetrics& m, double share, SensorMetrics& mean) {
  mean.mean += share * m.mean;
  mean.autonomy += share * m.autonomy;
  mean.continuous += share * m.continuous;
  for (std::size_t i = 0; i < m.useful.size(); ++i) mean.useful[i] += share * m.useful[i];
  mean.sun_hours += share * m.sun_hours;
  mean.glare += share * m.glare;
}

/// Metrics of one hour.
SensorMetrics metrics_of_hour(double lux, double sun, const MetricLimits& limits) {
  SensorMetrics out;
  out.mean = lux;
  out.autonomy = lux >= limits.autonomy ? 1 : 0;
  out.continuous = std::min(lux / limits.autonomy, 1.0);
  const auto bin = std::upper_bound(limits.useful.begin(), limits.useful.end(), lux) - limits.useful.begin();
  out.useful[static_cast<std::size_t>(bin)] = 1;
  out.sun_hours = sun >= limits.sun ? 1 : 0;
  out.glare = simplified_glare(lux) >= limits.glare ? 1 : 0;
  return out;
}

}  // namespace

double simplified_glare(double vertical_illuminance) { return 6.22e-5 * vertical_illuminance + 0.184; }

GlareMetrics glare_metrics(std::span<const float> dgp, std::span<const std::uint8_t> occupied) {
  constexpr double kExceeding = 0.05;
  std::vector<float> rated;
  GlareMetrics out;
  for (std::size_t i = 0; i < dgp.size(); ++i) {
    if (occupied[i] == 0) continue;
    rated.push_back(dgp[i]);
    for (std::size_t k = 0; k < kGlareClasses.size(); ++k) out.hours_above[k] += dgp[i] > kGlareClasses[k] ? 1 : 0;
  }
  if (rated.empty()) return out;
  // No more than that share of the hours lie before it.
  const auto at = static_cast<std::ptrdiff_t>(kExceeding * static_cast<double>(rated.size()));
  std::nth_element(rated.begin(), rated.begin() + at, rated.end(), std::greater<>());
  out.exceeded = rated[static_cast<std::size_t>(at)];
  return out;
}

std::vector<SensorMetrics> metrics_of(const Year& year, std::span<const std::uint8_t> occupied,
                                      const MetricLimits& limits) {
  const auto hours = std::count_if(occupied.begin(), occupied.end(), [](std::uint8_t o) { return o != 0; });
  std::vector<SensorMetrics> out(year.sensors);
  if (hours == 0) return out;
  parallel_for_each(year.sensors, 1, [&](std::size_t sensor) {
    for (std::size_t hour = 0; hour < year.hours; ++hour) {
      if (!occupied[hour]) continue;
      const double sun = year.sun[sensor * year.hours + hour];
      add_share(metrics_of_hour(year.at(sensor, hour), sun, limits), 1, out[sensor]);
    }
    SensorMetrics mean;
    add_share(out[sensor], 1 / static_cast<double>(hours), mean);
    mean.sun_hours = out[sensor].sun_hours;
    out[sensor] = mean;
  });
  return out;
}

ZoneMetrics metrics_of_zone(std::span<const SensorMetrics> metrics, std::span<const std::uint32_t> chosen,
                            std::span<const float> weight, const MetricLimits& limits) {
  ZoneMetrics out;
  out.sensors = chosen.size();
  double area = 0;
  for (const std::uint32_t i : chosen) area += weight[i];
  for (const std::uint32_t i : chosen) {
    const double share = weight[i] / area;
    // Shares of whole hours are not rounded away from the limit.
    constexpr double kRounding = 1e-9;
    if (metrics[i].autonomy >= limits.autonomy_share - kRounding) out.spatial_autonomy += share;
    if (metrics[i].sun_hours > limits.sun_hours) out.sun_exposure += share;
    add_share(metrics[i], share, out.mean);
  }
  return out;
}

std::vector<std::uint8_t> occupied_hours(const std::string& text, std::span<const WeatherHour> hours) {
  const std::vector<double> v = numbers_of<double>(text, '-');
  const bool good =
      v.size() == 2 && v[0] >= 0 && v[1] <= 24 && v[0] < v[1] && v[0] == std::floor(v[0]) && v[1] == std::floor(v[1]);
  if (!good) throw Error(fmt::format("'{}' names no hours", text), "Write whole hours as FROM-TO, for example 8-18.");
  std::vector<std::uint8_t> out;
  for (const WeatherHour& hour : hours) out.push_back(hour.hour > v[0] && hour.hour <= v[1]);
  return out;
}

std::vector<std::uint32_t> parse_schedule(std::string_view text, const std::string& path, std::size_t hours,
                                          std::uint32_t most) {
  std::vector<std::uint32_t> out;
  text = without_byte_order_mark(text);
  int number = 0;
  while (!text.empty()) {
    std::string_view line = take_line(text);
    ++number;
    line = line.substr(0, line.find_last_not_of(" \t\r\"") + 1);
    if (line.empty() || line.front() == '#') continue;
    std::string_view word = line.substr(std::min(line.find_last_of(", \t;") + 1, line.size()));
    double value = 0;
    const bool is_number = take_number(word, value) && word.empty();
    if (!is_number && number == 1) continue;  // a heading
    if (!is_number || !(value >= 0 && value <= most) || value != std::floor(value)) {
      throw Error({path, number},
                  fmt::format("'{}' does not end in a whole number from 0 to {}", line.substr(0, 60), most),
                  "Give one a line, for each hour of the weather file.");
    }
    out.push_back(static_cast<std::uint32_t>(value));
  }
  if (out.size() != hours)
    throw Error({path}, fmt::format("has {} hours; the weather file has {}", out.size(), hours),
                "Give one number a line, for each hour of the weather file.");
  return out;
}

}  // namespace glowworm
