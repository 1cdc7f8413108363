// Baked scenes: glowworm/bake.h.
#include "glowworm/bake.h"

#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "python/bindings.h"

namespace py = pybind11;

namespace glowworm::python {

void bind_bake(py::module_& module) {
  const auto with_words = [](const api::Scene& scene, const std::string& path,
                             std::vector<std::pair<std::string, std::string>> more, const std::string& format,
                             const std::string& light, int atlas, double texels_per_metre,
                             std::optional<float> exposure, bool allow_outside, const py::object& progress) {
    api::BakeOptions options{{}, format, light, atlas, texels_per_metre, exposure, allow_outside};
    options.render.more = std::move(more);
    const py::gil_scoped_release release;
    api::bake(scene, path, options, reporter(progress));
  };
  module.def("_bake", with_words, py::arg("scene"), py::arg("path"), py::arg("options"), py::arg("format"),
             py::arg("light"), py::arg("atlas"), py::arg("texels_per_metre"), py::arg("exposure"),
             py::arg("allow_outside"), py::arg("progress"));
}

}  // namespace glowworm::python
