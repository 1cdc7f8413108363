#include "import/mesh_file.h"

#include <filesystem>
#include <utility>

#include "core/error.h"
#include "core/input_file.h"
#include "import/mesh_tools.h"
#include "import/phong.h"
#include "import/ply/reader.h"
#include "import/stl/reader.h"
#include "import/texture_cache.h"

namespace glowworm {

namespace {

/// The scene of one mesh with one material.
/// @param mesh all its vertex arrays have full length
SceneDescription scene_of(Geometry mesh, const PhongMaterial& material, const std::string& path,
                          const ImportOptions& options, NoteCounter& notes) {
  const Reservation held(*options.budget, "meshes", mesh_bytes(mesh));
  const std::filesystem::path full(path);
  SceneDescription description;
  description.name = full.stem().string();
  TextureCache textures(options, notes);
  const auto load = [&](const PhongTexture& texture, const TextureOptions& texture_options, StandIn stand_in) {
    return textures.load_file(find_texture_file(full.parent_path().string(), texture.name), texture_options, stand_in);
  };
  const std::uint32_t emission = add_phong_material(material, {load, notes, description});
  notes.add("triangle wound against its normals, reversed", wind_by_normals(mesh));
  const Reservation triangles(*options.budget, "triangles", scene_bytes(mesh));
  append_counted(description.geometry, mesh, path, 0, emission, notes);
  if (description.geometry.triangles.empty()) {
    throw Error({path}, "has no triangles that can be shown", "Export meshes, not curves or points.");
  }
  notes.write_to(description.notes);
  return description;
}

Geometry read_stl(const std::string& path, MemoryBudget& budget, CoordinateOrigin& origin) {
  Reservation held(budget, "scene files", 0);
  return parse_stl(read_input_file(path, held), path, budget, origin);
}

}  // namespace

SceneDescription load_ply(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin) {
  PlyMesh source = read_ply(path, *options.budget, origin);
  NoteCounter notes;
  notes.add("face of fewer than three corners, left out", source.smaller_faces);
  if (source.has_colors) notes.add("mesh with colours at its vertices, not used");
  if (source.textures > 1)
    notes.add("mesh with several textures: only the last texture is used, '" + source.texture + "'");
  source.normals.resize(source.positions.size());
  source.uvs.resize(source.positions.size());
  PhongMaterial material;
  material.name = "DefaultMaterial";
  material.diffuse = RGB(kDefaultAlbedo);
  material.diffuse_map.name = source.texture;
  if (!source.texture.empty()) material.diffuse = RGB(1.0f);
  return scene_of(std::move(source), material, path, options, notes);
}

SceneDescription load_stl(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin) {
  Geometry mesh = read_stl(path, *options.budget, origin);
  NoteCounter notes;
  notes.add("triangle wound against its normals, reversed", wind_by_normals(mesh));
  // The facet's normal now adds nothing to the winding.
  mesh.normals.assign(mesh.positions.size(), Vec3{0, 0, 0});
  merge_identical_vertices(mesh);
  PhongMaterial material;
  material.name = "DefaultMaterial";
  material.diffuse = RGB(kDefaultAlbedo);
  return scene_of(std::move(mesh), material, path, options, notes);
}

}  // namespace glowworm
