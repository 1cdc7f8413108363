// Sensors: glowworm/sensors.h and glowworm/daylight.h.
#include "glowworm/sensors.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "glowworm/daylight.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/options.h"

namespace glowworm::python {

namespace {

py::dict measure(const api::Scene& scene, const py::object& points, const py::object& normals, bool on_surfaces,
                 const py::object& progress, const py::kwargs& more) {
  const Floats at = vectors(points, "points");
  const Floats facing = vectors(normals, "normals", at.shape(0), "points");
  api::MeasureOptions options;
  options.render.more = options_of(more);
  options.on_surfaces = on_surfaces;
  api::Measurement measured;
  {
    const py::gil_scoped_release release;
    measured = api::measure(scene, rows<api::Vec3>(at), rows<api::Vec3>(facing), options, reporter(progress));
  }
  py::dict out;
  out["irradiance"] = owned<float>(std::move(measured.irradiance));
  out["direct"] = owned<float>(std::move(measured.direct));
  out["indirect"] = owned<float>(std::move(measured.indirect));
  out["caustic"] = owned<float>(std::move(measured.caustic));
  out["illuminance"] = owned<float>(std::move(measured.illuminance));
  out["relative_error"] = owned<float>(std::move(measured.relative_error));
  return out;
}

/// The array of a year, of shape (sensors, columns).
py::array by_sensor(std::vector<float> values, std::size_t sensors) {
  const auto rows = static_cast<py::ssize_t>(sensors);
  const py::ssize_t columns = static_cast<py::ssize_t>(values.size()) / rows;
  return owned<float>(std::move(values)).reshape({rows, columns});
}

/// Whole numbers, one for each hour.
template <typename Number>
std::vector<Number> by_hour(const py::object& argument, const char* name) {
  std::vector<Number> out;
  if (argument.is_none()) return out;
  for (const py::handle& value : argument)
    out.push_back(static_cast<Number>(count_of(value, name, std::numeric_limits<Number>::max())));
  return out;
}

/// Options that daylight() and annual_glare() share.
api::DaylightOptions options_of_year(const py::dict& given, const py::kwargs& more) {
  api::DaylightOptions o;
  o.render.more = options_of(more);
  o.sky_patches = given["sky_patches"].cast<int>();
  o.ground = given["ground"].cast<double>();
  o.sun_step = given["sun_step"].cast<double>();
  o.turn = given["turn"].cast<double>();
  o.hours = given["hours"].cast<std::string>();
  o.occupied = by_hour<std::uint8_t>(given["occupied"], "occupied");
  for (const py::handle& shade : given["shades"]) o.shades.push_back(shade.cast<api::Scene>());
  o.shade_of_hour = by_hour<std::uint32_t>(given["shade_of_hour"], "shade_of_hour");
  return o;
}

py::dict daylight(const api::Scene& scene, const std::string& weather, const py::object& points,
                  const py::object& normals, const py::dict& given, const py::object& progress,
                  const py::kwargs& more) {
  const Floats at = vectors(points, "points");
  const Floats facing = vectors(normals, "normals", at.shape(0), "points");
  api::DaylightOptions o = options_of_year(given, more);
  o.on_surfaces = given["on_surfaces"].cast<bool>();
  if (const py::object area = given["area"]; !area.is_none()) {
    const Floats values = floats(area, "area");
    o.area.assign(values.data(), values.data() + values.size());
  }
  o.autonomy_lux = given["autonomy_lux"].cast<double>();
  o.sun_lux = given["sun_lux"].cast<double>();
  o.sun_hours = given["sun_hours"].cast<double>();
  o.useful = given["useful"].cast<std::array<double, 3>>();
  o.glare = given["glare"].cast<double>();
  api::Daylight year;
  {
    const py::gil_scoped_release release;
    year = api::daylight(scene, weather, rows<api::Vec3>(at), rows<api::Vec3>(facing), o, reporter(progress));
  }
  const std::size_t sensors = year.mean.size();
  py::dict out;
  out["hours"] = owned<std::int32_t>(std::move(year.hours));
  out["illuminance"] = by_sensor(std::move(year.illuminance), sensors);
  out["sun"] = by_sensor(std::move(year.sun), sensors);
  out["mean"] = owned<float>(std::move(year.mean));
  out["autonomy"] = owned<float>(std::move(year.autonomy));
  out["continuous"] = owned<float>(std::move(year.continuous));
  out["useful"] = by_sensor(std::move(year.useful), sensors);
  out["sun_hours"] = owned<float>(std::move(year.sun_hours));
  out["glare"] = owned<float>(std::move(year.glare));
  out["daylight_factor"] = owned<float>(std::move(year.daylight_factor));
  out["relative_error"] = owned<float>(std::move(year.relative_error));
  out["sDA"] = year.spatial_autonomy;
  out["ASE"] = year.sun_exposure;
  return out;
}

py::dict annual_glare(const api::Scene& scene, const std::string& weather, const std::vector<api::Camera>& views,
                      const py::dict& given, const py::object& progress, const py::kwargs& more) {
  api::DaylightOptions o = options_of_year(given, more);
  o.view_pixels = given["view_pixels"].cast<int>();
  api::AnnualGlare year;
  {
    const py::gil_scoped_release release;
    year = api::annual_glare(scene, weather, views, o, reporter(progress));
  }
  py::list out_views;
  for (api::ViewGlare& view : year.views) {
    py::dict out;
    out["dgp"] = owned<float>(std::move(view.dgp));
    out["illuminance"] = owned<float>(std::move(view.illuminance));
    out["dgp_error"] = owned<float>(std::move(view.dgp_error));
    out["illuminance_error"] = owned<float>(std::move(view.illuminance_error));
    out["exceeded"] = view.exceeded;
    out["perceptible"] = view.perceptible;
    out["disturbing"] = view.disturbing;
    out["intolerable"] = view.intolerable;
    out_views.append(std::move(out));
  }
  py::dict out;
  out["hours"] = owned<std::int32_t>(std::move(year.hours));
  out["views"] = std::move(out_views);
  return out;
}

}  // namespace

void bind_sensors(py::module_& module) {
  module.def("_measure", &measure, py::arg("scene"), py::arg("points"), py::arg("normals"), py::arg("on_surfaces"),
             py::arg("progress"));
  module.def("_daylight", &daylight, py::arg("scene"), py::arg("weather"), py::arg("points"), py::arg("normals"),
             py::arg("given"), py::arg("progress"));
  module.def("_annual_glare", &annual_glare, py::arg("scene"), py::arg("weather"), py::arg("views"), py::arg("given"),
             py::arg("progress"));
}

}  // namespace glowworm::python
