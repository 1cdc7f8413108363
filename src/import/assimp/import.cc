#include "import/assimp/import.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/input_file.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "import/assimp/hand_over.h"
#include "import/instance_keeper.h"
#include "import/mesh_tools.h"
#include "import/notes.h"
#include "import/phong.h"
#include "import/reader_process.h"
#include "import/texture_cache.h"

namespace glowworm {

namespace {

Vec3 unit_or_zero(Vec3 n) {
  const float l = length(n);
  return l > 0 && std::isfinite(l) ? n / l : Vec3{0, 0, 0};
}

/// Builds a scene description from the output of glowworm-assimp.
class ForeignBuilder {
 public:
  ForeignBuilder(const ForeignScene& scene, const std::string& path, const ImportOptions& options, NoteCounter& notes,
                 CoordinateOrigin& origin)
      : origin_(origin),
        scene_(scene),
        path_(path),
        notes_(notes),
        triangles_(*options.budget, "triangles", 0),
        keeper_(description_.geometry, origin_, triangles_),
        textures_(options, notes) {}

  SceneDescription build() {
    const std::filesystem::path path(path_);
    description_.name = path.stem().string();
    const std::string folder = path.parent_path().string();
    const PhongContext context{[&](const PhongTexture& texture, const TextureOptions& options, StandIn stand_in) {
                                 return image_of(folder, texture, options, stand_in);
                               },
                               notes_, description_};
    triangles_.grow(scene_.materials.size() * material_bytes());
    for (const PhongMaterial& material : scene_.materials) {
      emissions_.push_back(add_phong_material(material, context));
    }
    for (const ForeignInstance& instance : scene_.instances) {
      check_cancelled();
      add_mesh(scene_.meshes[instance.mesh], instance.to_world);
    }
    description_.geometry.number_instances();
    for (const ForeignCamera& camera : scene_.cameras) add_camera(camera);
    for (const ForeignLight& light : scene_.lights) add_light(light);
    notes_.add("animation: the first moment is shown", scene_.animations);
    return std::move(description_);
  }

 private:
  std::shared_ptr<const TextureImage> image_of(const std::string& folder, const PhongTexture& texture,
                                               const TextureOptions& options, StandIn stand_in) {
    if (texture.embedded == kNone)
      return textures_.load_file(find_texture_file(folder, texture.name), options, stand_in);
    const std::string& bytes = scene_.embedded[texture.embedded];
    return textures_.load_memory(texture.name, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                                 options, stand_in);
  }

  void add_mesh(const ForeignMesh& source, const TransformDouble& to_world) {
    if (source.has_points_or_lines) notes_.add("points or lines, left out");
    if (source.has_bones) notes_.add("skin: the mesh is shown as it was modelled");
    if (source.has_colors) notes_.add("mesh with colours at its vertices, not used");
    const std::uint32_t emission = emissions_[source.material];
    if (emission == kNone && keeper_.keep(&source, to_world, source.name, [&] {
          SharedMesh shared;
          append_counted(shared.geometry, mesh_of(source), path_ + ": " + source.name, source.material, kNone, notes_);
          return shared;
        }) != kNone)
      return;
    Geometry mesh = mesh_of(source);
    place_mesh(mesh, to_world, origin_);
    triangles_.grow(scene_bytes(mesh));
    description_.geometry.begin_object(source.name);
    append_counted(description_.geometry, mesh, path_ + ": " + source.name, source.material, emission, notes_);
  }

  /// A mesh in its own space.
  Geometry mesh_of(const ForeignMesh& source) {
    Geometry mesh;
    mesh.positions = source.positions;
    mesh.uvs = source.uvs;
    mesh.uvs.resize(mesh.positions.size());
    for (const Vec3& normal : source.normals) mesh.normals.push_back(unit_or_zero(normal));
    mesh.normals.resize(mesh.positions.size());
    mesh.triangles = source.triangles;
    merge_identical_vertices(mesh);
    notes_.add("triangle wound against its normals, reversed", wind_by_normals(mesh));
    return mesh;
  }

  void add_camera(const ForeignCamera& source) {
    const Transform to_world = source.to_world.relative_to(origin_.origin());
    Camera camera;
    camera.name = source.name;
    const Vec3 forward = unit_or_zero(to_world.vector(source.look_at));
    const Vec3 right = unit_or_zero(cross(forward, to_world.vector(source.up)));
    const Vec3 position = origin_.relative(source.to_world.point(Vec3d(source.position)));
    if (length_squared(right) == 0 || !is_finite(position)) {
      notes_.add("camera '" + camera.name + "' has no place or direction, left out");
      return;
    }
    camera.to_world = {right, cross(right, forward), forward, position};
    camera.aspect = source.aspect;
    const float shorter = source.aspect > 1 && std::isfinite(source.aspect)
                              ? 1 / source.aspect
                              : 1;  // Assimp's angles and widths are horizontal
    if (source.orthographic_width > 0 && std::isfinite(source.orthographic_width)) {
      camera.kind = CameraKind::orthographic;
      camera.half_extent = source.orthographic_width * shorter;
    } else {
      const float angle = std::isfinite(source.horizontal_fov) ? source.horizontal_fov : 0.5f;
      camera.half_extent = std::tan(std::clamp(angle, 0.001f, 1.57f)) * shorter;
    }
    description_.cameras.push_back(std::move(camera));
  }

  void add_light(const ForeignLight& source) {
    Light light;
    light.name = source.name;
    light.intensity = source.intensity;
    light.position = origin_.relative(source.to_world.point(Vec3d(source.position)));
    const bool needs_direction = source.kind != ForeignLightKind::point;
    if (needs_direction) light.direction = unit_or_zero(narrow(source.to_world.vector(Vec3d(source.direction))));
    if (source.kind == ForeignLightKind::point) {
      light.kind = LightKind::point;
    } else if (source.kind == ForeignLightKind::spot) {
      light.kind = LightKind::spot;
      light.cos_inner = std::cos(source.inner_angle / 2);
      light.cos_outer = std::min(std::cos(source.outer_angle / 2), light.cos_inner);
    } else if (source.kind == ForeignLightKind::directional) {
      light.kind = LightKind::directional;
    } else {
      notes_.add("area or ambient light, left out");
      return;
    }
    const bool finite = is_finite(light.intensity) && is_finite(light.position) && std::isfinite(light.cos_inner) &&
                        std::isfinite(light.cos_outer);
    if (!finite || (needs_direction && length_squared(light.direction) == 0)) {
      notes_.add("light '" + light.name + "' has no place, direction or brightness, left out");
      return;
    }
    notes_.add("light intensity of a file without units, taken as W sr^-1 (or W m^-2)");
    description_.lights.push_back(std::move(light));
  }

  CoordinateOrigin& origin_;
  const ForeignScene& scene_;
  const std::string& path_;
  NoteCounter& notes_;
  Reservation triangles_;
  InstanceKeeper keeper_;
  TextureCache textures_;
  SceneDescription description_;
  std::vector<std::uint32_t> emissions_;  ///< for each material
};

}  // namespace

SceneDescription load_assimp(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin,
                             const ChildLimits& limits) {
  const ReaderProgram program{"glowworm-assimp", "Assimp",
                              "Open it in the program that wrote it and export it again, as glTF if possible.",
                              options.assimp_program};
  Reservation held(*options.budget, "scene files", 0);
  const std::string bytes = run_reader(program, path, {}, limits_for(path, *options.budget, limits), held);
  return build_assimp_scene(bytes, path, options, origin);
}

SceneDescription build_assimp_scene(std::string_view bytes, const std::string& path, const ImportOptions& options,
                                    CoordinateOrigin& origin) {
  const Reservation meshes(*options.budget, "meshes", bytes.size());  // both forms have about the same size
  const ForeignScene scene = read_foreign_scene(bytes, path);
  for (const std::string& name : scene.files) record_input_file(name);
  NoteCounter notes;
  SceneDescription description = ForeignBuilder(scene, path, options, notes, origin).build();
  if (description.geometry.triangle_count() == 0) {
    throw Error({path}, "has no triangles that can be shown", "Export meshes, not curves or points.");
  }
  notes.write_to(description.notes);
  return description;
}

bool assimp_reads(const std::string& extension) {
  static constexpr std::string_view kExtensions[] = {".3ds",  ".3mf", ".ac",  ".amf", ".ase", ".b3d", ".blend", ".dae",
                                                     ".dxf",  ".fbx", ".ifc", ".lwo", ".lws", ".lxo", ".ms3d",  ".off",
                                                     ".ogex", ".x",   ".x3d", ".xgl", ".zae", ".zgl"};
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) != std::end(kExtensions);
}

}  // namespace glowworm
