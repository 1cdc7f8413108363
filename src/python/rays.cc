// Rays: glowworm/rays.h.
#include "glowworm/rays.h"

#include <pybind11/stl.h>

#include <string>

#include "python/arrays.h"
#include "python/bindings.h"

namespace glowworm::python {

namespace {

using api::Hits;
using api::Tracer;

/// The arrays of a batch of rays.
struct RayArrays {
  Floats origins, directions, t_max;

  RayArrays(const py::object& o, const py::object& d, const py::object& far)
      : origins(vectors(o, "origins")), directions(vectors(d, "directions", origins.shape(0), "origins")) {
    if (far.is_none()) return;
    t_max = floats(far, "t_max");
    if (t_max.ndim() > 1 || (t_max.ndim() == 1 && t_max.size() != origins.shape(0)))
      throw py::value_error("there are " + std::to_string(t_max.size()) + " values of t_max for " +
                            std::to_string(origins.shape(0)) + " origins; expected one for all, or one for each");
  }
  api::Rays rays(float t_min) const {
    return {rows<api::Vec3>(origins), rows<api::Vec3>(directions), t_min, rows<float>(t_max)};
  }
};

constexpr const char* kRays =
    "origins: (n, 3), metres. directions: (n, 3), need not be unit. t_min, t_max: hits count between these, in "
    "lengths\n"
    "of the direction; t_max is one number or (n,). A ray that leaves a surface needs a small t_min.";

template <typename Number, typename T>
py::array hit_array(const py::object& self, const std::vector<T>& values) {
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values.size())};
  if (sizeof(T) != sizeof(Number)) shape.push_back(sizeof(T) / sizeof(Number));
  return view(reinterpret_cast<const Number*>(values.data()), shape, self, true);
}

}  // namespace

void bind_rays(py::module_& module) {
  py::class_<Hits>(module, "Hits", "Closest hits of rays. The arrays are views of this object's memory.")
      .def_property_readonly(
          "distance", [](const py::object& self) { return hit_array<float>(self, self.cast<Hits&>().distance); },
          "(n,), in lengths of the ray's direction; infinite for no hit.")
      // As signed numbers: kNoTriangle is -1.
      .def_property_readonly(
          "triangle", [](const py::object& self) { return hit_array<std::int32_t>(self, self.cast<Hits&>().triangle); },
          "(n,), index into Scene.triangles; -1 for no hit.")
      .def_property_readonly(
          "barycentric", [](const py::object& self) { return hit_array<float>(self, self.cast<Hits&>().barycentric); },
          "(n, 2), weights of the second and third vertex.")
      .def_property_readonly(
          "normal", [](const py::object& self) { return hit_array<float>(self, self.cast<Hits&>().normal); },
          "(n, 3), unit, by the winding of the triangle; zeros for no hit.")
      .def("__len__", [](const Hits& self) { return self.distance.size(); });
  py::class_<Tracer>(module, "Tracer", "Traces rays in a scene. Several threads may use it.")
      .def(py::init<const api::Scene&>(), py::arg("scene"))
      .def(
          "intersect",
          [](const Tracer& self, const py::object& origins, const py::object& directions, float t_min,
             const py::object& t_max) {
            const RayArrays arrays(origins, directions, t_max);
            const py::gil_scoped_release release;
            return self.intersect(arrays.rays(t_min));
          },
          py::arg("origins"), py::arg("directions"), py::kw_only(), py::arg("t_min") = 0, py::arg("t_max") = py::none(),
          (std::string("Closest hits of a batch of rays, on all threads. ") + kRays).c_str())
      .def(
          "occluded",
          [](const Tracer& self, const py::object& origins, const py::object& directions, float t_min,
             const py::object& t_max) {
            const RayArrays arrays(origins, directions, t_max);
            std::vector<std::uint8_t> out;
            {
              const py::gil_scoped_release release;
              out = self.occluded(arrays.rays(t_min));
            }
            return owned<std::uint8_t>(std::move(out)).view("bool");
          },
          py::arg("origins"), py::arg("directions"), py::kw_only(), py::arg("t_min") = 0, py::arg("t_max") = py::none(),
          (std::string("Whether anything lies on each ray, (n,) of bool. ") + kRays).c_str());
}

}  // namespace glowworm::python
