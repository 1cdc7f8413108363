// Renders: glowworm/render.h.
#include "glowworm/render.h"

#include <pybind11/stl.h>

#include <memory>

#include "glowworm/bake.h"
#include "glowworm/sensors.h"
#include "python/bindings.h"
#include "python/options.h"

namespace glowworm::python {

namespace py = pybind11;

void bind_render(py::module_& module) {
  using api::Render;
  const auto release = py::call_guard<py::gil_scoped_release>();
  // The package gives it keywords.
  py::class_<Render>(module, "_Render")
      .def(py::init([](const api::Scene& scene, const py::kwargs& options) {
             api::RenderOptions all;
             all.more = options_of(options);
             const py::gil_scoped_release unlocked;
             return std::make_unique<Render>(scene, all);
           }),
           py::arg("scene"))
      .def("cancel", &Render::cancel)
      .def("wait", &Render::wait, release)
      .def("wait_for", &Render::wait_for, py::arg("seconds"), release)
      .def("done", &Render::done)
      .def("cancelled", &Render::cancelled)
      .def("progress", &Render::progress)
      .def(
          "picture", [](const Render& self) { return std::make_shared<api::Picture>(self.picture()); }, release)
      .def(
          "statistics", [](const Render& self) { return self.statistics().json; }, release);
  py::class_<api::FrameSequence>(module, "_FrameSequence")
      .def(py::init([](const api::Scene& scene, const std::vector<api::Camera>& cameras, const py::kwargs& options) {
             api::RenderOptions all;
             all.more = options_of(options);
             return std::make_unique<api::FrameSequence>(scene, cameras, all);
           }),
           py::arg("scene"), py::arg("cameras"))
      .def(
          "render",
          [](api::FrameSequence& self, std::size_t frame, const py::object& progress) {
            const auto report = reporter(progress);
            const py::gil_scoped_release unlocked;
            return std::make_shared<api::Picture>(self.render(frame, report));
          },
          py::arg("frame"), py::arg("progress"));
  module.def("aov_names", &api::aov_names, "Names of the layers that renders can have beside the image.");
  module.def("_render_option_names", &api::render_option_names);
  module.def("_measure_option_names", &api::measure_option_names);
  module.def("_bake_option_names", &api::bake_option_names);
}

}  // namespace glowworm::python
