// The Python module glowworm._glowworm. The package around it is src/python/glowworm/.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <exception>

#include "glowworm/glowworm.h"
#include "python/bindings.h"

namespace py = pybind11;

namespace glowworm::python {
namespace {

void bind_error(py::module_& module) {
  static py::exception<Error> type(module, "Error", PyExc_RuntimeError);
  type.attr("__doc__") =
      "An error of Glowworm. The text says what is wrong, where, and what to do.\n\n"
      "code: 'invalid' (a setting, an argument or a scene makes no sense), 'file' (a file is missing, damaged, not\n"
      "supported, or cannot be written) or 'memory' (the memory is too small). place: (file, line, column), with 0 "
      "for\n"
      "what is not known; None for errors without a file.";
  type.attr("__module__") = "glowworm";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      constexpr const char* kCodes[] = {"invalid", "file", "memory"};  // by ErrorCode
      const py::object raised = py::handle(type)(error.what());
      raised.attr("code") = kCodes[static_cast<std::size_t>(error.code())];
      const FilePlace& place = error.place();
      raised.attr("place") =
          place.file.empty() ? py::object(py::none()) : py::make_tuple(place.file, place.line, place.column);
      PyErr_SetObject(type.ptr(), raised.ptr());
    }
  });
}

}  // namespace
}  // namespace glowworm::python

PYBIND11_MODULE(_glowworm, module) {
  using namespace glowworm;
  module.doc() = "Bindings of Glowworm's C++ interface.";
  module.attr("__version__") = api::version();
  python::bind_error(module);
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
