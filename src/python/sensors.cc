// Sensors: glowworm/sensors.h.
#include "glowworm/sensors.h"

#include <utility>

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

}  // namespace

void bind_sensors(py::module_& module) {
  module.def("_measure", &measure, py::arg("scene"), py::arg("points"), py::arg("normals"), py::arg("on_surfaces"),
             py::arg("progress"));
}

}  // namespace glowworm::python
