// Baked scenes: glowworm/bake.h.
#include "glowworm/bake.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "python/arrays.h"
#include "python/bindings.h"
#include "python/options.h"

namespace py = pybind11;

namespace glowworm::python {

void bind_bake(py::module_& module) {
  const auto with_words = [](const api::Scene& scene, const std::filesystem::path& path, const std::string& format,
                             const std::string& light, const py::object& atlas, double texels_per_metre,
                             std::optional<float> exposure, bool allow_outside, const py::object& progress,
                             const py::kwargs& more) {
    api::BakeOptions options;
    options.render.more = options_of(more);
    options.format = choice<api::BakeFormat>("format", format, api::bake_format_names());
    options.indirect_only = choice<int>("light", light, {"all", "indirect"}) == 1;
    options.atlas = static_cast<int>(count_of(atlas, "atlas", std::numeric_limits<int>::max()));
    options.texels_per_metre = texels_per_metre;
    options.exposure = exposure;
    options.allow_outside = allow_outside;
    const py::gil_scoped_release release;
    api::bake(scene, path.string(), options, reporter(progress));
  };
  module.def("_bake", with_words, py::arg("scene"), py::arg("path"), py::arg("format"), py::arg("light"),
             py::arg("atlas"), py::arg("texels_per_metre"), py::arg("exposure"), py::arg("allow_outside"),
             py::arg("progress"));
}

}  // namespace glowworm::python
