// The Python module glowworm._glowworm. The package around it is src/python/glowworm/.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "glowworm/glowworm.h"
#include "python/bindings.h"

namespace py = pybind11;

PYBIND11_MODULE(_glowworm, module) {
  using namespace glowworm;
  module.doc() = "Bindings of Glowworm's C++ interface.";
  module.attr("__version__") = api::version();
  const py::exception<Error> error = py::register_exception<Error>(module, "Error", PyExc_RuntimeError);
  error.attr("__doc__") = "An error of Glowworm. The text says what is wrong, where, and what to do.";
  error.attr("__module__") = "glowworm";
  module.def("set_threads", &api::set_threads, py::arg("threads"),
             "Sets the number of threads of all work; 0: one for each hardware thread.");
  python::bind_scene(module);
  python::bind_picture(module);
  python::bind_render(module);
  python::bind_photons(module);
  python::bind_rays(module);
  python::bind_sensors(module);
  python::bind_bake(module);
}
