#include "measure/year_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/error.h"
#include "core/json_text.h"
#include "core/text.h"
#include "measure/measurement.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr const char* kUseful[4] = {"UDI_below", "UDI_supplementary", "UDI_autonomous", "UDI_exceeded"};

/// Metrics that sensors and zones have, by the names of columns.
std::vector<std::pair<std::string, double>> common_metrics(const SensorMetrics& m) {
  std::vector<std::pair<std::string, double>> out = {{"E_mean_lx", m.mean}, {"DA", m.autonomy}, {"cDA", m.continuous}};
  for (std::size_t i = 0; i < m.useful.size(); ++i) out.emplace_back(kUseful[i], m.useful[i]);
  out.emplace_back("sun_hours", m.sun_hours);
  return out;
}

/// All metrics of a sensor but for glare.
std::vector<std::pair<std::string, double>> columns_of(const RatedYear& r, std::size_t i) {
  std::vector<std::pair<std::string, double>> out = common_metrics(r.metrics[i]);
  out.emplace_back("daylight_factor", r.daylight_factor[i]);
  out.emplace_back("relative_error", r.relative_error[i]);
  return out;
}

}  // namespace

bool RatedBox::contains(Vec3d p) const {
  for (int axis = 0; axis < 3; ++axis)
    if (p[axis] < min[axis] || p[axis] > max[axis]) return false;
  return true;
}

RatedBox parse_rated_box(const std::string& text) {
  constexpr std::size_t kNumbers = 6;
  const std::size_t comma = text.find(',');
  const std::vector<double> v =
      comma == std::string::npos ? std::vector<double>() : numbers_of<double>(std::string_view(text).substr(comma + 1));
  if (comma == 0 || v.size() != kNumbers)
    throw Error(fmt::format("--box '{}' names no box", text), "Write NAME,X0,Y0,Z0,X1,Y1,Z1 (m).");
  RatedBox out{text.substr(0, comma), {}, {}};
  for (int axis = 0; axis < 3; ++axis) {
    const double a = v[static_cast<std::size_t>(axis)], b = v[static_cast<std::size_t>(axis) + 3];
    out.min[axis] = std::min(a, b);
    out.max[axis] = std::max(a, b);
  }
  return out;
}

std::string year_csv(const Year& year, std::span<const WeatherHour> hours, const std::string& about) {
  std::string text = fmt::format(
      "# {}\n# illuminance of each sensor in lx, by {} lm/W; each hour is given by its end, in standard time\n"
      "month,day,hour",
      one_line(about), kLuminousEfficacy);
  for (std::size_t sensor = 0; sensor < year.sensors; ++sensor)
    fmt::format_to(std::back_inserter(text), ",E{}", sensor);
  text += '\n';
  for (std::size_t hour = 0; hour < year.hours; ++hour) {
    const WeatherHour& h = hours[hour];
    fmt::format_to(std::back_inserter(text), "{},{},{}", h.moment.month, h.moment.day, h.hour);
    for (std::size_t sensor = 0; sensor < year.sensors; ++sensor)
      fmt::format_to(std::back_inserter(text), ",{:.4g}", year.at(sensor, hour));
    text += '\n';
  }
  return text;
}

std::string glare_text(std::size_t number, const ViewYear& view, std::span<const std::uint8_t> occupied) {
  const GlareMetrics g = glare_metrics(view.dgp, occupied);
  double of_dgp = 0, of_lux = 0, lux = 0;
  std::size_t hours = 0;
  for (std::size_t i = 0; i < view.dgp.size(); ++i) {
    if (!occupied[i] || !(view.illuminance[i] > 0)) continue;
    ++hours;
    of_dgp += double{view.dgp_error[i]} * view.dgp_error[i];
    of_lux += double{view.illuminance_error[i]} * view.illuminance_error[i];
    lux += double{view.illuminance[i]} * view.illuminance[i];
  }
  return fmt::format(
      "view {}: DGP {:.3f} is exceeded in 5% of the occupied hours; above {:.2f}: {} h, above {:.2f}: {} h, above "
      "{:.2f}: {} h; standard error of DGP {:.2g}, of vertical illuminance {:.2g}%",
      number + 1, g.exceeded, kGlareClasses[0], g.hours_above[0], kGlareClasses[1], g.hours_above[1], kGlareClasses[2],
      g.hours_above[2], hours > 0 ? std::sqrt(of_dgp / static_cast<double>(hours)) : 0.0,
      lux > 0 ? 100 * std::sqrt(of_lux / lux) : 0.0);
}

std::string glare_csv(std::span<const ViewYear> views, std::span<const WeatherHour> hours,
                      std::span<const std::uint8_t> occupied, const std::string& about) {
  std::string text = fmt::format(
      "# {}\n# DGP and vertical illuminance (lx) of each view, and their standard errors; each hour is given "
      "by its end, in standard time\n",
      one_line(about));
  for (std::size_t i = 0; i < views.size(); ++i) text += "# " + glare_text(i, views[i], occupied) + "\n";
  text += "month,day,hour";
  for (std::size_t i = 0; i < views.size(); ++i)
    fmt::format_to(std::back_inserter(text), ",DGP{0},E_v{0}_lx,DGP{0}_error,E_v{0}_error_lx", i + 1);
  text += '\n';
  for (std::size_t hour = 0; hour < hours.size(); ++hour) {
    const WeatherHour& h = hours[hour];
    fmt::format_to(std::back_inserter(text), "{},{},{}", h.moment.month, h.moment.day, h.hour);
    for (const ViewYear& view : views)
      fmt::format_to(std::back_inserter(text), ",{:.3f},{:.4g},{:.2g},{:.2g}", view.dgp[hour], view.illuminance[hour],
                     view.dgp_error[hour], view.illuminance_error[hour]);
    text += '\n';
  }
  return text;
}

std::string zone_text(const std::string& name, const ZoneMetrics& z, const MetricLimits& limits) {
  return fmt::format(
      "{}: {} sensors, sDA({:g} lx, {:g}%) {:.1f}%, ASE({:g} lx, {:g} h) {:.1f}%, UDI {:.1f}/{:.1f}/{:.1f}/{:.1f}%, "
      "cDA {:.1f}%",
      name, z.sensors, limits.autonomy, 100 * limits.autonomy_share, 100 * z.spatial_autonomy, limits.sun,
      limits.sun_hours, 100 * z.sun_exposure, 100 * z.mean.useful[0], 100 * z.mean.useful[1], 100 * z.mean.useful[2],
      100 * z.mean.useful[3], 100 * z.mean.continuous);
}

std::string metrics_csv(const RatedYear& r, const std::string& about) {
  std::string text = fmt::format("# {}\n", one_line(about));
  for (std::size_t i = 0; i < r.zones.size(); ++i)
    text += "# " + zone_text(r.zone_names[i], r.zones[i], r.limits) + "\n";
  text +=
      "# shares of the occupied hours; sun_hours: hours of direct sun; daylight_factor: share of the illuminance "
      "outside;\n# DGPs_hours: share of hours with glare, of sensors that face the horizon\nx,y,z,nx,ny,nz";
  if (!r.metrics.empty())
    for (const auto& [name, value] : columns_of(r, 0)) text += "," + name;
  text += ",DGPs_hours\n";
  for (std::size_t i = 0; i < r.metrics.size(); ++i) {
    const Vec3d p = r.place[i];
    const Vec3 n = r.normal[i];
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.9g},{:.9g},{:.6g},{:.6g},{:.6g}", p.x, p.y, p.z, n.x, n.y, n.z);
    for (const auto& [name, value] : columns_of(r, i)) fmt::format_to(std::back_inserter(text), ",{:.5g}", value);
    text += r.upright[i] ? fmt::format(",{:.5g}\n", r.metrics[i].glare) : std::string(",\n");
  }
  return text;
}

std::string metrics_json(const RatedYear& r, const std::string& about) {
  json out = {{"about", about},
              {"limits",
               {{"autonomy_lx", r.limits.autonomy},
                {"autonomy_share", r.limits.autonomy_share},
                {"sun_lx", r.limits.sun},
                {"sun_hours", r.limits.sun_hours},
                {"useful_lx", r.limits.useful},
                {"DGPs", r.limits.glare}}},
              {"zones", json::array()},
              {"sensors", json::array()}};
  for (std::size_t i = 0; i < r.zones.size(); ++i) {
    json zone = {{"name", r.zone_names[i]},
                 {"sensors", r.zones[i].sensors},
                 {"sDA", r.zones[i].spatial_autonomy},
                 {"ASE", r.zones[i].sun_exposure}};
    for (const auto& [name, value] : common_metrics(r.zones[i].mean)) zone[name] = value;
    out["zones"].push_back(zone);
  }
  for (std::size_t i = 0; i < r.metrics.size(); ++i) {
    json sensor = {{"x", r.place[i].x},   {"y", r.place[i].y},   {"z", r.place[i].z},
                   {"nx", r.normal[i].x}, {"ny", r.normal[i].y}, {"nz", r.normal[i].z}};
    for (const auto& [name, value] : columns_of(r, i)) sensor[name] = value;
    if (r.upright[i]) sensor["DGPs_hours"] = r.metrics[i].glare;
    out["sensors"].push_back(sensor);
  }
  return json_text(out, 1) + "\n";
}

}  // namespace glowworm
