// Rays: glowworm/rays.h.
#include "glowworm/rays.h"

#include <pybind11/stl.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "glowworm/error.h"
#include "python/arrays.h"
#include "python/bindings.h"

namespace glowworm::python {

namespace {

using api::Tracer;

/// The arrays of a batch of rays.
struct RayArrays {
  Floats origins, directions, t_max;

  RayArrays(const py::object& o, const py::object& d, const py::object& far)
      : origins(vectors(o, "origins", Check::later)),
        directions(vectors(d, "directions", origins.shape(0), "origins", Check::later)) {
    if (far.is_none()) return;
    t_max = floats(far, "t_max", Check::later);
    if (t_max.ndim() > 1 || (t_max.ndim() == 1 && t_max.size() != origins.shape(0)))
      throw py::value_error("there are " + std::to_string(t_max.size()) + " values of t_max for " +
                            std::to_string(origins.shape(0)) + " origins; expected one for all, or one for each");
  }
  /// Calls trace(rays) without the lock of the interpreter. It checks all numbers; its errors for those that are not
  /// finite become those of other arrays.
  template <typename Trace>
  void traced(float t_min, Trace&& trace) const {
    try {
      const py::gil_scoped_release release;
      trace(api::Rays{rows<api::Vec3>(origins), rows<api::Vec3>(directions), t_min, rows<float>(t_max)});
    } catch (const Error&) {
      check_finite(origins, "origins");
      check_finite(directions, "directions");
      for (py::ssize_t i = 0; i < t_max.size(); ++i)
        if (std::isnan(t_max.data()[i]))
          throw py::value_error("t_max[" + std::to_string(i) + "] is nan; expected numbers");
      throw;
    }
  }
};

constexpr const char* kRays =
    "origins: (n, 3), metres. directions: (n, 3), need not be unit. t_min, t_max: hits count between these, in "
    "lengths\n"
    "of the direction; t_max is one number or (n,), and may be inf. A ray that leaves a surface needs a small t_min.";

/// Closest hits, in arrays that NumPy has allocated: of a large array it uses huge pages.
struct RayHits {
  Tracer tracer;
  py::array_t<float> distance;
  py::array_t<std::int32_t> triangle;  ///< signed: kNoTriangle is -1
  py::array_t<float> barycentric;
  py::object normals = py::none();  ///< made when they are first asked for

  RayHits(const Tracer& of, py::ssize_t count)
      : tracer(of), distance(count), triangle(count), barycentric({count, py::ssize_t{2}}) {}
  std::size_t size() const { return static_cast<std::size_t>(distance.size()); }
  std::span<std::uint32_t> triangles() { return {reinterpret_cast<std::uint32_t*>(triangle.mutable_data()), size()}; }
  api::HitSpans spans() {
    return {{distance.mutable_data(), size()},
            triangles(),
            {reinterpret_cast<api::Vec2*>(barycentric.mutable_data()), size()}};
  }
};

std::unique_ptr<RayHits> intersect(const Tracer& tracer, const py::object& origins, const py::object& directions,
                                   float t_min, const py::object& t_max) {
  const RayArrays arrays(origins, directions, t_max);
  auto hits = std::make_unique<RayHits>(tracer, arrays.origins.shape(0));
  const api::HitSpans spans = hits->spans();
  arrays.traced(t_min, [&](const api::Rays& rays) { tracer.intersect(rays, spans); });
  return hits;
}

py::object normals_of(RayHits& hits) {
  if (!hits.normals.is_none()) return hits.normals;
  const std::span<const std::uint32_t> triangles = hits.triangles();
  return hits.normals = owned_result<float>([&] { return hits.tracer.normals(triangles); });
}

}  // namespace

void bind_rays(py::module_& module) {
  py::class_<RayHits>(module, "Hits", "Closest hits of rays.")
      .def_readonly("distance", &RayHits::distance, "(n,), in lengths of the ray's direction; infinite for no hit.")
      .def_readonly("triangle", &RayHits::triangle, "(n,), index into Scene.triangles; -1 for no hit.")
      .def_readonly("barycentric", &RayHits::barycentric, "(n, 2), weights of the second and third vertex.")
      .def_property_readonly("normal", &normals_of,
                             "(n, 3), unit, by the winding of the triangle; zeros for no hit. Made on first use.")
      .def("__len__", &RayHits::size);
  py::class_<Tracer>(module, "Tracer", "Traces rays in a scene. Several threads may use it.")
      .def(py::init<const api::Scene&>(), py::arg("scene"))
      .def("intersect", &intersect, py::arg("origins"), py::arg("directions"), py::kw_only(), py::arg("t_min") = 0,
           py::arg("t_max") = py::none(),
           (std::string("Closest hits of a batch of rays, on all threads. ") + kRays).c_str())
      .def(
          "occluded",
          [](const Tracer& self, const py::object& origins, const py::object& directions, float t_min,
             const py::object& t_max) {
            const RayArrays arrays(origins, directions, t_max);
            std::vector<std::uint8_t> out;
            arrays.traced(t_min, [&](const api::Rays& rays) { out = self.occluded(rays); });
            return owned<std::uint8_t>(std::move(out)).view("bool");
          },
          py::arg("origins"), py::arg("directions"), py::kw_only(), py::arg("t_min") = 0, py::arg("t_max") = py::none(),
          (std::string("Whether anything lies on each ray, (n,) of bool. ") + kRays).c_str());
}

}  // namespace glowworm::python
