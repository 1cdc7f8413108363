#include "import/assimp/hand_over.h"

#include "core/archive.h"
#include "core/error.h"

namespace glowworm {

template <>
inline constexpr bool kPlain<TransformDouble> = sizeof(TransformDouble) == 96;

namespace {

constexpr std::uint32_t kMagic = 0x32617767, kEnd = 0x646e6567;

}  // namespace

template <typename Archive>
void transfer(Archive& archive, PhongTexture& t) {
  transfer_all(archive, t.name, t.embedded);
  transfer_enum(archive, t.wrap_u, TextureWrap::black);
  transfer_enum(archive, t.wrap_v, TextureWrap::black);
  transfer(archive, t.by_second_uvs);
}

template <typename Archive>
void transfer(Archive& archive, PhongMaterial& m) {
  transfer_all(archive, m.name, m.diffuse, m.specular, m.emissive, m.filter, m.exponent, m.opacity, m.ior, m.model,
               m.metallic, m.roughness, m.diffuse_map, m.opacity_map, m.emissive_map, m.normal_map, m.has_metal_maps);
}

template <typename Archive>
void transfer(Archive& archive, ForeignMesh& m) {
  transfer_all(archive, m.name, m.material, m.has_points_or_lines, m.has_bones, m.has_colors, m.positions, m.normals,
               m.uvs, m.triangles);
}

template <typename Archive>
void transfer(Archive& archive, ForeignInstance& i) {
  transfer_all(archive, i.mesh, i.to_world);
}

template <typename Archive>
void transfer(Archive& archive, ForeignCamera& c) {
  transfer_all(archive, c.name, c.to_world, c.position, c.look_at, c.up, c.aspect, c.horizontal_fov,
               c.orthographic_width);
}

template <typename Archive>
void transfer(Archive& archive, ForeignLight& l) {
  transfer_all(archive, l.name, l.to_world);
  transfer_enum(archive, l.kind, ForeignLightKind::other);
  transfer_all(archive, l.intensity, l.position, l.direction, l.inner_angle, l.outer_angle);
}

template <typename Archive>
void transfer_mark(Archive& archive, std::uint32_t expected) {
  std::uint32_t mark = expected;
  transfer(archive, mark);
  if (mark != expected) fail_transfer("it is not of this version of the program");
}

template <typename Archive>
void transfer(Archive& archive, ForeignScene& scene) {
  transfer_mark(archive, kMagic);
  transfer_all(archive, scene.files, scene.embedded, scene.materials, scene.meshes, scene.instances, scene.cameras,
               scene.lights, scene.animations);
  transfer_mark(archive, kEnd);
}

namespace {

void check_indices(const ForeignScene& scene) {
  for (const PhongMaterial& m : scene.materials) {
    for (const PhongTexture* map : {&m.diffuse_map, &m.opacity_map, &m.emissive_map, &m.normal_map}) {
      if (map->embedded != kNone && map->embedded >= scene.embedded.size()) fail_transfer("a texture is not there");
    }
  }
  for (const ForeignMesh& mesh : scene.meshes) {
    const std::size_t count = mesh.positions.size();
    if (mesh.material >= scene.materials.size()) fail_transfer("a mesh has a material that is not there");
    if (count >= kNone) fail_transfer("a mesh has more vertices than can be indexed");
    if (!mesh.normals.empty() && mesh.normals.size() != count)
      fail_transfer("a mesh has not one normal for each vertex");
    if (!mesh.uvs.empty() && mesh.uvs.size() != count)
      fail_transfer("a mesh has not one texture vertex for each vertex");
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t vertex : triangle) {
        if (vertex >= count) fail_transfer("a triangle has a vertex that is not there");
      }
    }
  }
  for (const ForeignInstance& instance : scene.instances) {
    if (instance.mesh >= scene.meshes.size()) fail_transfer("a node has a mesh that is not there");
  }
}

}  // namespace

void write_foreign_scene(const ForeignScene& scene, const std::function<void(const void*, std::size_t)>& write) {
  ArchiveWriter writer(write);
  transfer(writer, const_cast<ForeignScene&>(scene));  // a writer does not change the scene
}

ForeignScene read_foreign_scene(std::string_view bytes, const std::string& file) try {
  auto scene = unarchived<ForeignScene>(std::as_bytes(std::span(bytes)));
  check_indices(scene);
  return scene;
} catch (const InvalidArchive& invalid) {
  throw Error({file}, std::string("Assimp's output is invalid: ") + invalid.what(),
              "Open it in the program that wrote it and export it again, as glTF if possible.");
}

}  // namespace glowworm
