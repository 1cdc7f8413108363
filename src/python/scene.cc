// Scenes: glowworm/scene.h.
#include "glowworm/scene.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "python/arrays.h"
#include "python/bindings.h"
#include "python/options.h"

namespace glowworm::python {

namespace {

using api::Camera;
using api::Material;
using api::Scene;
using api::SceneBuilder;

// In the order of Material::Kind.
const std::vector<std::string> kKinds = {"diffuse", "metal", "glass", "glossy", "pane", "plastic", "interface"};

/// Media on the sides of a surface: an index, -1 for vacuum, or None.
std::optional<std::uint32_t> side(std::optional<std::int64_t> medium, const char* name) {
  if (!medium) return std::nullopt;
  if (*medium < -1 || *medium >= api::kVacuum) throw py::value_error(std::string(name) + " is no index of a medium");
  return *medium == -1 ? api::kVacuum : static_cast<std::uint32_t>(*medium);
}

/// Adds a material with media on its sides.
std::uint32_t add_material(SceneBuilder& builder, Material material, std::optional<std::int64_t> inside,
                           std::optional<std::int64_t> outside) {
  material.inside = side(inside, "inside");
  material.outside = side(outside, "outside");
  return builder.add_material(material);
}

/// The numbers of add_medium(): a colour for all of the medium, or a grid of them, whose shape all grids share.
class MediumArrays {
 public:
  /// Reads an argument as a colour, or as a grid of colours, of which `grid` is set and the colour is 1.
  api::Rgb color_or_grid(const py::object& argument, const char* name, std::span<const api::Rgb>& grid) {
    const Floats array = floats(argument, name);
    if (array.ndim() != 4) return color(argument, name);
    if (array.shape(3) != 3) throw py::value_error(std::string(name) + " is not of shape (nz, ny, nx, 3)");
    grid = rows<api::Rgb>(keep(array, name));
    return {1, 1, 1};
  }
  std::span<const float> density(const py::object& argument) {
    if (argument.is_none()) return {};
    const Floats array = floats(argument, "density");
    if (array.ndim() != 3) throw py::value_error("density is not of shape (nz, ny, nx)");
    return rows<float>(keep(array, "density"));
  }
  const std::array<int, 3>& cells() const { return cells_; }

 private:
  const Floats& keep(const Floats& array, const char* name) {
    const std::array<int, 3> cells{static_cast<int>(array.shape(2)), static_cast<int>(array.shape(1)),
                                   static_cast<int>(array.shape(0))};
    if (!kept_.empty() && cells != cells_)
      throw py::value_error(std::string(name) + " has another number of cells than the grids before it");
    cells_ = cells;
    kept_.push_back(array);
    return kept_.back();
  }

  std::vector<Floats> kept_;
  std::array<int, 3> cells_{0, 0, 0};
};

std::uint32_t add_medium(SceneBuilder& builder, const py::object& absorption, const py::object& scattering, float g,
                         const py::object& emission, const py::object& box, const py::object& density,
                         const std::string& name) {
  api::Medium medium;
  MediumArrays arrays;
  medium.absorption = arrays.color_or_grid(absorption, "absorption", medium.absorption_grid);
  medium.scattering = arrays.color_or_grid(scattering, "scattering", medium.scattering_grid);
  medium.emission = arrays.color_or_grid(emission, "emission", medium.emission_grid);
  medium.density_grid = arrays.density(density);
  medium.cells = arrays.cells();
  medium.mean_cosine = g;
  if (!box.is_none()) {
    const Floats corners = vectors(box, "box");
    if (corners.shape(0) != 2) throw py::value_error("box is not of shape (2, 3)");
    medium.box = {rows<api::Vec3>(corners)[0], rows<api::Vec3>(corners)[1]};
  }
  medium.name = name;
  return builder.add_medium(medium);
}

/// The options of add_mesh() beside the arrays.
struct MeshOptions {
  std::uint32_t material = 0;
  py::object normals, uvs, radiance;
  bool two_sided = false;
  std::string name;
};

/// Calls add(mesh) with a mesh of arrays.
template <typename Add>
void with_mesh(const py::object& positions, const py::object& indices, const MeshOptions& o, const Add& add) {
  const Floats vertices = vectors(positions, "positions");
  const auto corners = triangles(indices, "triangles");
  const Floats normals = o.normals.is_none() ? Floats() : vectors(o.normals, "normals", vertices.shape(0), "positions");
  const Floats uvs = o.uvs.is_none() ? Floats() : floats(o.uvs, "uvs");
  if (uvs.size() > 0 && (uvs.ndim() != 2 || uvs.shape(1) != 2)) throw py::value_error("uvs are not of shape (n, 2)");
  api::Mesh mesh;
  mesh.positions = rows<api::Vec3>(vertices);
  mesh.triangles = rows<api::Triangle>(corners);
  mesh.normals = rows<api::Vec3>(normals);
  mesh.uvs = rows<api::Vec2>(uvs);
  mesh.material = o.material;
  if (!o.radiance.is_none()) mesh.radiance = color(o.radiance, "radiance");
  mesh.two_sided = o.two_sided;
  mesh.name = o.name;
  add(mesh);
}

/// The places of instances: (n, 3, 4) or (n, 4, 4).
std::vector<api::Placement> placements(const py::object& transforms) {
  const Floats array = floats(transforms, "transforms");
  if (array.ndim() != 3 || array.shape(1) < 3 || array.shape(1) > 4 || array.shape(2) != 4)
    throw py::value_error("transforms are not of shape (n, 3, 4) or (n, 4, 4)");
  const auto values = array.unchecked<3>();
  std::vector<api::Placement> out(static_cast<std::size_t>(array.shape(0)));
  for (py::ssize_t i = 0; i < array.shape(0); ++i)
    for (py::ssize_t row = 0; row < 3; ++row)
      for (py::ssize_t column = 0; column < 4; ++column)
        out[static_cast<std::size_t>(i)][static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
            values(i, row, column);
  return out;
}

/// Throws ValueError unless an image has red, green and blue.
void check_rgb(const Floats& image, const char* name) {
  if (image.ndim() != 3) throw py::value_error(std::string(name) + " is not of shape (height, width, 3)");
  if (image.shape(2) != 3)
    throw py::value_error(std::string(name) + " has " + std::to_string(image.shape(2)) + " channels; expected 3");
}

std::uint32_t add_texture(SceneBuilder& builder, const py::object& image) {
  const Floats array = floats(image, "image");
  check_rgb(array, "image");
  return builder.add_texture(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), rows<api::Rgb>(array));
}

void set_environment(SceneBuilder& builder, const py::object& radiance) {
  const Floats array = floats(radiance, "radiance");
  if (array.ndim() != 3) return builder.set_environment(color(radiance, "radiance"));
  check_rgb(array, "radiance");
  builder.set_environment(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), rows<api::Rgb>(array));
}

/// A scene with edits by the names of lights: {"lamp": {"scale": 2}}.
Scene with_lights(const Scene& scene, const std::map<std::string, py::dict>& edits) {
  std::vector<api::LightEdit> all;
  for (const auto& [name, given] : edits) {
    api::LightEdit& edit = all.emplace_back();
    edit.light = name;
    for (const auto& [key, value] : given) {
      const auto what = key.cast<std::string>();
      if (what == "on")
        edit.on = value.cast<bool>();
      else if (what == "scale")
        edit.scale = value.cast<float>();
      else if (what == "move")
        edit.move = vector(value, "move");
      else if (what == "turn")
        edit.turn = vector(value, "turn");
      else
        throw py::value_error("'" + what + "' is not one of on, scale, move, turn");
    }
  }
  const py::gil_scoped_release release;
  return scene.with_lights(all);
}

const std::vector<std::string> kProjections = {"perspective", "fisheye", "hemispherical", "panorama"};

Camera::Projection projection_of(const std::string& name) {
  return choice<Camera::Projection>("projection", name, kProjections);
}

void bind_camera(py::module_& module) {
  const auto set = [](api::Vec3 Camera::*member, const char* name) {
    return [member, name](Camera& camera, const py::object& value) { camera.*member = vector(value, name); };
  };
  const auto get = [](api::Vec3 Camera::*member) {
    return [member](const Camera& camera) {
      const api::Vec3 v = camera.*member;
      return py::make_tuple(v.x, v.y, v.z);
    };
  };
  py::class_<Camera>(module, "Camera", "A camera. Lengths are metres, angles degrees.")
      .def(py::init([](const py::object& eye, const py::object& target, const py::object& up, float field_of_view,
                       float orthographic_size, float lens_radius, float focal_distance, const std::string& name,
                       const std::string& projection) {
             return Camera{vector(eye, "eye"),       vector(target, "target"),
                           vector(up, "up"),         field_of_view,
                           orthographic_size,        lens_radius,
                           focal_distance,           name,
                           projection_of(projection)};
           }),
           py::arg("eye"), py::arg("target"), py::arg("up") = py::make_tuple(0, 1, 0), py::kw_only(),
           py::arg("field_of_view") = 40, py::arg("orthographic_size") = 0, py::arg("lens_radius") = 0,
           py::arg("focal_distance") = 0, py::arg("name") = "camera", py::arg("projection") = "perspective",
           "eye, target, up: three numbers, metres. field_of_view: degrees along the shorter side of the picture.\n"
           "orthographic_size: metres that the shorter side shows; 0: a perspective camera. lens_radius: metres; 0: a\n"
           "pinhole. focal_distance: metres at which a lens is sharp; 0: at the target. projection: 'perspective',\n"
           "'fisheye' (equidistant), 'hemispherical' (orthographic fisheye) or 'panorama' (equirectangular).")
      .def_property("eye", get(&Camera::eye), set(&Camera::eye, "eye"))
      .def_property("target", get(&Camera::target), set(&Camera::target, "target"))
      .def_property("up", get(&Camera::up), set(&Camera::up, "up"))
      .def_readwrite("field_of_view", &Camera::field_of_view)
      .def_readwrite("orthographic_size", &Camera::orthographic_size)
      .def_readwrite("lens_radius", &Camera::lens_radius)
      .def_readwrite("focal_distance", &Camera::focal_distance)
      .def_readwrite("name", &Camera::name)
      .def_property(
          "projection", [](const Camera& c) { return kProjections.at(static_cast<std::size_t>(c.projection)); },
          [](Camera& c, const std::string& name) { c.projection = projection_of(name); })
      .def(py::pickle(
          [](const Camera& c) {
            const auto three = [](api::Vec3 v) { return py::make_tuple(v.x, v.y, v.z); };
            return py::make_tuple(three(c.eye), three(c.target), three(c.up), c.field_of_view, c.orthographic_size,
                                  c.lens_radius, c.focal_distance, c.name, static_cast<int>(c.projection));
          },
          [](const py::tuple& state) {
            if (state.size() != 9) throw py::value_error("this is not a pickled camera");
            return Camera{vector(state[0], "eye"),
                          vector(state[1], "target"),
                          vector(state[2], "up"),
                          state[3].cast<float>(),
                          state[4].cast<float>(),
                          state[5].cast<float>(),
                          state[6].cast<float>(),
                          state[7].cast<std::string>(),
                          static_cast<Camera::Projection>(state[8].cast<int>())};
          }));
}

void bind_scene_class(py::module_& module) {
  py::class_<Scene>(module, "Scene", "An immutable scene. Several threads may use it.")
      .def_static(
          "load",
          [](const std::filesystem::path& path, const py::kwargs& given) {
            api::LoadOptions options;
            options.more = options_of(given);
            const py::gil_scoped_release release;
            return Scene::load(path.string(), options);
          },
          py::arg("path"),
          "Reads a file by its extension (.pbrt, .gltf, .glb, .obj, ...), or makes a built-in scene from\n"
          "'builtin:NAME'. The keywords are the options of `glowworm render` under the heading Scene: up, scale,\n"
          "environment, sky, studio_light and others. Raises Error with file, place and remedy.")
      .def_property_readonly("name", &Scene::name)
      .def_property_readonly("cameras", &Scene::cameras, "Names of the cameras; there is at least one.")
      .def_property_readonly("materials", &Scene::materials, "Names of the materials.")
      .def_property_readonly("notes", &Scene::notes,
                             "Features of the file that are not supported or had to be guessed.")
      .def_property_readonly(
          "positions",
          [](const py::object& self) { return view_of<float>(self.cast<const Scene&>().positions(), self); },
          "Vertices of all triangles, (n, 3), metres. A view of the scene's memory.")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) { return view_of<std::uint32_t>(self.cast<const Scene&>().triangles(), self); },
          "Indices into positions, (m, 3). A view of the scene's memory.")
      .def_property_readonly(
          "triangle_materials",
          [](const py::object& self) {
            return view_of<std::uint32_t>(self.cast<const Scene&>().triangle_materials(), self);
          },
          "Index into materials of each triangle, (m,). A view of the scene's memory.")
      .def_property_readonly("lights", &Scene::lights, "Names of the lights.")
      .def("with_lights", &with_lights, py::arg("edits"),
           "Returns the same scene with changed lights. edits: for names of lights a dict with 'on', 'scale' (a "
           "factor),\n"
           "'move' (metres) and 'turn' (axis times radians), or some of these.")
      .def("with_camera", &Scene::with_camera, py::arg("camera"),
           "Returns the same scene with one more camera. It shares all else.")
      .def("__repr__", [](const Scene& scene) {
        return "<glowworm.Scene '" + scene.name() + "', " + std::to_string(scene.triangle_count()) + " triangles>";
      });
  module.def("builtin_scenes", &api::builtin_scenes, "Names of the built-in scenes, for Scene.load('builtin:NAME').");
}

void bind_builder_lights(py::class_<SceneBuilder>& builder) {
  builder
      .def(
          "add_point_light",
          [](SceneBuilder& self, const py::object& position, const py::object& intensity) {
            self.add_point_light(vector(position, "position"), color(intensity, "intensity"));
          },
          py::arg("position"), py::arg("intensity"), "position: metres. intensity: W sr^-1, RGB or one number.")
      .def(
          "add_spot_light",
          [](SceneBuilder& self, const py::object& position, const py::object& direction, const py::object& intensity,
             float inner_angle, float outer_angle) {
            self.add_spot_light({vector(position, "position"), vector(direction, "direction"),
                                 color(intensity, "intensity"), inner_angle, outer_angle});
          },
          py::arg("position"), py::arg("direction"), py::arg("intensity"), py::kw_only(), py::arg("inner_angle") = 30,
          py::arg("outer_angle") = 40,
          "position: metres. direction: of travel. intensity: W sr^-1 along the axis. The intensity is full up to\n"
          "inner_angle from the axis and 0 from outer_angle on, both in degrees.")
      .def(
          "add_directional_light",
          [](SceneBuilder& self, const py::object& direction, const py::object& irradiance) {
            self.add_directional_light(vector(direction, "direction"), color(irradiance, "irradiance"));
          },
          py::arg("direction"), py::arg("irradiance"),
          "direction: of travel. irradiance: W m^-2 on a surface that faces the light.")
      .def(
          "set_environment", &set_environment, py::arg("radiance"),
          "Light from all directions: W sr^-1 m^-2, RGB or one number; or an image of all directions, (height, width,\n"
          "3), row by row from the top (+y), whose middle column looks along -z.");
}

void bind_builder_meshes(py::class_<SceneBuilder>& builder) {
  builder
      .def(
          "add_mesh",
          [](SceneBuilder& self, const py::object& positions, const py::object& indices, std::uint32_t material,
             const py::object& normals, const py::object& uvs, const py::object& radiance, bool two_sided,
             const std::string& name) {
            with_mesh(positions, indices, {material, normals, uvs, radiance, two_sided, name},
                      [&](const api::Mesh& mesh) { self.add_mesh(mesh); });
          },
          py::arg("positions"), py::arg("triangles"), py::kw_only(), py::arg("material") = 0,
          py::arg("normals") = py::none(), py::arg("uvs") = py::none(), py::arg("radiance") = py::none(),
          py::arg("two_sided") = false, py::arg("name") = "mesh",
          "Adds triangles. The arrays are copied.\n\n"
          "positions: (n, 3), metres. triangles: (m, 3), indices into positions, counter-clockwise seen from outside.\n"
          "material: returned by add_material(). normals: (n, 3), unit, for smooth shading. uvs: (n, 2), texture\n"
          "coordinates. radiance: W sr^-1 m^-2, RGB or one number, emitted by the front, and by the back if two_sided.")
      .def(
          "add_instances",
          [](SceneBuilder& self, const py::object& positions, const py::object& indices, const py::object& transforms,
             std::uint32_t material, const py::object& normals, const py::object& uvs, const py::object& radiance,
             bool two_sided, const std::string& name) {
            with_mesh(positions, indices, {material, normals, uvs, radiance, two_sided, name},
                      [&](const api::Mesh& mesh) { self.add_instances(mesh, placements(transforms)); });
          },
          py::arg("positions"), py::arg("triangles"), py::arg("transforms"), py::kw_only(), py::arg("material") = 0,
          py::arg("normals") = py::none(), py::arg("uvs") = py::none(), py::arg("radiance") = py::none(),
          py::arg("two_sided") = false, py::arg("name") = "mesh",
          "Adds a mesh at many places, with little memory for each unless it emits light. The arrays are those of\n"
          "add_mesh(), in the mesh's own space. transforms: (n, 3, 4) or (n, 4, 4), matrices from there to the world.\n"
          "Each place is an object whose name has a number.");
}

void bind_builder(py::module_& module) {
  py::class_<SceneBuilder> builder(module, "SceneBuilder", "Makes a scene from arrays, step by step.");
  builder.def(py::init<const std::string&>(), py::arg("name") = "scene")
      .def(
          "add_material",
          [](SceneBuilder& self, const std::string& kind, const py::object& rgb, float roughness, float metallic,
             float ior, std::optional<std::uint32_t> color_texture, const std::string& name,
             std::optional<std::int64_t> inside, std::optional<std::int64_t> outside, bool unseen) {
            return add_material(self,
                                {choice<Material::Kind>("kind", kind, kKinds),
                                 color(rgb, "color"),
                                 color_texture,
                                 roughness,
                                 metallic,
                                 ior,
                                 name,
                                 {},
                                 {},
                                 unseen},
                                inside, outside);
          },
          py::arg("kind") = "diffuse", py::kw_only(), py::arg("color") = 0.5, py::arg("roughness") = 0.0f,
          py::arg("metallic") = 0.0f, py::arg("ior") = 1.5f, py::arg("color_texture") = py::none(),
          py::arg("name") = "", py::arg("inside") = py::none(), py::arg("outside") = py::none(),
          py::arg("unseen") = false,
          "Adds a material and returns its index.\n\n"
          "kind: 'diffuse', 'metal', 'glass', 'glossy' (glTF's metallic-roughness), 'pane' (glass without thickness)\n"
          "'plastic' (diffuse under a clear coat) or 'interface' (lets light pass, parts media). color: RGB or one "
          "number in [0, 1]. roughness: GGX alpha in\n"
          "[0, 1]; of 'glossy' its square root. ior: index of refraction. color_texture: returned by add_texture(); a\n"
          "factor on color. inside, outside: media on the two sides, returned by add_medium(); -1: vacuum; None: what "
          "is\n"
          "around. unseen: cameras do not see the surface; mirrors, glass and all other light meet it.")
      .def("add_medium", &add_medium, py::arg("absorption") = 0.0f, py::arg("scattering") = 0.0f, py::kw_only(),
           py::arg("g") = 0.0f, py::arg("emission") = 0.0f, py::arg("box") = py::none(),
           py::arg("density") = py::none(), py::arg("name") = "medium",
           "Adds a medium, such as fog, and returns its index.\n\n"
           "absorption, scattering: coefficients, m^-1. emission: W sr^-1 m^-2; the medium emits this times "
           "absorption.\n"
           "Each is RGB, one number, or a grid of colours across the box, (nz, ny, nx, 3). density: (nz, ny, nx), a "
           "factor\non both coefficients. g: mean cosine of the phase function, in (-1, 1). box: two corners, metres; "
           "None: all\nspace that the medium is in.")
      .def("set_ambient_medium", &SceneBuilder::set_ambient_medium, py::arg("medium"),
           "Fills all space that no surface encloses by name. Without a box, the medium lets no light from infinity "
           "pass.")
      .def(
          "add_texture", &add_texture, py::arg("image"),
          "Adds a texture and returns its index. image: (height, width, 3), linear RGB in [0, 1], row by row from the\n"
          "top. It is filtered and repeats; (0, 0) is its lower left corner, (1, 1) its upper right one.")
      .def("add_camera", &SceneBuilder::add_camera, py::arg("camera"))
      .def("build", &SceneBuilder::build, py::call_guard<py::gil_scoped_release>(),
           "Returns the scene. Adds a camera that frames it if there is none, and a sky if there is no light. The\n"
           "builder is empty afterwards.");
  bind_builder_meshes(builder);
  bind_builder_lights(builder);
}

}  // namespace

void bind_scene(py::module_& module) {
  bind_camera(module);
  bind_scene_class(module);
  bind_builder(module);
}

}  // namespace glowworm::python
