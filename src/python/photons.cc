// Photons, photon maps and density estimation: glowworm/photons.h, glowworm/density.h.
#include "glowworm/photons.h"

#include <pybind11/stl.h>

#include <string>

#include "python/arrays.h"
#include "python/bindings.h"
#include "python/options.h"

namespace glowworm::python {

namespace {

using api::DensityIndex;
using api::Engine;
using api::Kernel;
using api::PhotonMap;
using api::Photons;

Kernel kernel_of(const std::string& name) { return choice<Kernel>("kernel", name, api::kernel_names()); }
Engine engine_of(const std::string& name) { return choice<Engine>("engine", name, api::engine_names()); }

void bind_photon_arrays(py::module_& module) {
  const auto array = [](auto member) {
    return [member](const py::object& self) { return view_of<float>((self.cast<const Photons&>().*member)(), self); };
  };
  py::class_<Photons>(module, "Photons",
                      "Photons on surfaces. The arrays have one length, are views of the photons' memory, and keep it "
                      "alive.")
      .def_property_readonly("positions", array(&Photons::positions), "(n, 3), metres.")
      .def_property_readonly("directions", array(&Photons::directions), "(n, 3), unit, back along the photon's path.")
      .def_property_readonly("flux", array(&Photons::flux),
                             "(n, 3), W, linear RGB, already divided by the number of paths.")
      .def_property_readonly("normals", array(&Photons::normals), "(n, 3), unit, on the side where the photon arrived.")
      .def_property_readonly("emitted", &Photons::emitted, "Number of emitted light paths.")
      .def("__len__", &Photons::size)
      .def("__repr__", [](const Photons& self) {
        return "<glowworm.Photons: " + std::to_string(self.size()) + " of " + std::to_string(self.emitted()) +
               " light paths>";
      });
  module.def(
      "trace_photons",
      [](const api::Scene& scene, const py::object& photons, const py::object& seed, bool caustic) {
        api::PhotonOptions options{count_of(photons, "photons"), count32_of(seed, "seed"), caustic};
        return interruptible([&](const Interrupt& interrupt) {
          options.interrupt = &interrupt;
          return api::trace_photons(scene, options);
        });
      },
      py::arg("scene"), py::kw_only(), py::arg("photons") = 500'000, py::arg("seed") = 0, py::arg("caustic") = false,
      "Traces photons from all lights. photons: the least number to store. caustic: only photons with at least one\n"
      "bounce and only specular bounces. Tracing ends without that number after 200 light paths for each photon, or\n"
      "after one for each if none is stored by then, such as in a scene without caustics. Ctrl-C stops it.");
}

void bind_photon_map(py::module_& module) {
  const auto at_points = [](auto member) {
    return [member](const PhotonMap& self, const py::object& points, const py::object& normals) {
      const Floats at = vectors(points, "points");
      const Floats facing = vectors(normals, "normals", at.shape(0), "points");
      return owned_result<float>([&] { return (self.*member)(rows<api::Vec3>(at), rows<api::Vec3>(facing)); });
    };
  };
  py::class_<PhotonMap>(module, "PhotonMap", "The photon map of all light of a scene.")
      .def(py::init([](const api::Scene& scene, const py::object& photons, const py::object& seed,
                       const py::object& nearest, const std::string& kernel, bool boundary_correction,
                       const std::string& engine) {
             api::PhotonMapOptions options{count_of(photons, "photons"),
                                           count32_of(seed, "seed"),
                                           count32_of(nearest, "nearest"),
                                           kernel_of(kernel),
                                           engine_of(engine),
                                           boundary_correction};
             return interruptible([&](const Interrupt& interrupt) {
               options.interrupt = &interrupt;
               return PhotonMap(scene, options);
             });
           }),
           py::arg("scene"), py::kw_only(), py::arg("photons") = 500'000, py::arg("seed") = 0, py::arg("nearest") = 50,
           py::arg("kernel") = "epanechnikov", py::arg("boundary_correction") = true, py::arg("engine") = "auto",
           "photons: the least number to store. nearest: photons that an estimate should catch. kernel: a name of the\n"
           "option --kernel; engine: of --engine. boundary_correction: correct photons whose kernel extends over the "
           "edge of a surface.\n"
           "Ctrl-C stops it.")
      .def("irradiance", at_points(&PhotonMap::irradiance), py::arg("points"), py::arg("normals"),
           "Irradiance at points on surfaces, (m, 3), W m^-2, direct and indirect. points: (m, 3), metres. normals:\n"
           "(m, 3), unit, on the side whose light is wanted.")
      .def("radiance", at_points(&PhotonMap::radiance), py::arg("points"), py::arg("normals"),
           "Radiance, (m, 3), W sr^-1 m^-2, that the surface at each point reflects along its normal. Raises Error for "
           "a\n"
           "point that is not on a surface.")
      .def_property_readonly("emitted", &PhotonMap::emitted, "Number of emitted light paths.")
      .def("__len__", &PhotonMap::size);
}

std::unique_ptr<DensityIndex> make_index(const py::object& positions, const py::object& flux, const py::object& radii,
                                         const py::object& normals, const std::string& kernel,
                                         const std::string& engine) {
  const Floats at = vectors(positions, "positions");
  const Floats power = vectors(flux, "flux", at.shape(0), "positions");
  const Floats facing = normals.is_none() ? Floats() : vectors(normals, "normals", at.shape(0), "positions");
  const Floats radius = floats(radii, "radii");
  const Kernel shape = kernel_of(kernel);
  const Engine way = engine_of(engine);
  if (radius.ndim() > 1 || (radius.ndim() == 1 && radius.size() != at.shape(0)))
    throw py::value_error("there are " + std::to_string(radius.size()) + " radii for " + std::to_string(at.shape(0)) +
                          " positions; expected one for all, or one for each");
  const api::PhotonArrays arrays{rows<api::Vec3>(at), rows<api::Rgb>(power), rows<api::Vec3>(facing)};
  const py::gil_scoped_release release;
  if (radius.ndim() == 0) return std::make_unique<DensityIndex>(arrays, radius.data()[0], shape, way);
  return std::make_unique<DensityIndex>(arrays, rows<float>(radius), shape, way);
}

void bind_density(py::module_& module) {
  py::class_<DensityIndex>(module, "DensityIndex", "Sums over photons around points, without a scene.")
      .def(py::init(&make_index), py::arg("positions"), py::arg("flux"), py::arg("radii"), py::kw_only(),
           py::arg("normals") = py::none(), py::arg("kernel") = "epanechnikov", py::arg("engine") = "auto",
           "positions: (n, 3), metres. flux: (n, 3), W, or any other quantity. radii: metres, one for all or (n,).\n"
           "normals: (n, 3), unit. kernel, engine: names of the options --kernel and --engine; not 'knn'. The arrays\n"
           "are copied.")
      .def(
          "sum",
          [](const DensityIndex& self, const py::object& points, const py::object& normals) {
            const Floats at = vectors(points, "points");
            const Floats facing = normals.is_none() ? Floats() : vectors(normals, "normals", at.shape(0), "points");
            return owned_result<float>([&] { return self.sum(rows<api::Vec3>(at), rows<api::Vec3>(facing)); });
          },
          py::arg("points"), py::arg("normals") = py::none(),
          "For each point the sum over photons within their radius h of kernel(distance / h) / h^2 times flux, (m, "
          "3):\n"
          "of flux in W the irradiance in W m^-2. Photons with normals count where they are less than 45 degrees away.")
      .def("__len__", &DensityIndex::photon_count);
  module.def(
      "photon_radii",
      [](const py::object& positions, const py::object& k) {
        const Floats at = vectors(positions, "positions");
        const std::uint32_t count = count32_of(k, "k");
        return owned_result<float>([&] { return api::photon_radii(rows<api::Vec3>(at), count); });
      },
      py::arg("positions"), py::arg("k") = 50, "A radius for each photon that holds about k photons, (n,), metres.");
}

}  // namespace

void bind_photons(py::module_& module) {
  bind_photon_arrays(module);
  bind_photon_map(module);
  bind_density(module);
}

}  // namespace glowworm::python
