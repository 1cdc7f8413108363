#include "import/assimp/import.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <vector>

#include "core/error.h"
#include "import/assimp/material.h"
#include "import/mesh_tools.h"
#include "import/notes.h"
#include "import/obj/scan.h"
#include "import/texture_cache.h"

namespace glowworm {

namespace {

Vec3 vector_of(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Transform transform_of(const aiMatrix4x4& m) {
  return {{m.a1, m.b1, m.c1}, {m.a2, m.b2, m.c2}, {m.a3, m.b3, m.c3}, {m.a4, m.b4, m.c4}};
}

/// Builds a description from what Assimp read.
class AssimpBuilder {
 public:
  AssimpBuilder(const aiScene& scene, const std::string& path, const ImportOptions& options, NoteCounter& notes)
      : scene_(scene),
        path_(path),
        notes_(notes),
        triangles_(*options.budget, "triangles", 0),
        textures_(options, notes) {}

  SceneDescription build() {
    const std::filesystem::path path(path_);
    description_.name = path.stem().string();
    AssimpMaterialContext context{scene_, path.parent_path().string(), textures_, notes_, description_};
    for (unsigned i = 0; i < scene_.mNumMaterials; ++i) {
      emissions_.push_back(add_assimp_material(*scene_.mMaterials[i], context));
    }
    if (scene_.mRootNode) visit(*scene_.mRootNode, Transform{});
    if (scene_.mNumAnimations > 0) notes_.add("animation: the first moment is shown", scene_.mNumAnimations);
    return std::move(description_);
  }

 private:
  void visit(const aiNode& node, const Transform& parent) {
    const Transform to_world = parent * transform_of(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) add_mesh(*scene_.mMeshes[node.mMeshes[i]], to_world);
    for (unsigned i = 0; i < scene_.mNumCameras; ++i) {
      if (scene_.mCameras[i]->mName == node.mName) add_camera(*scene_.mCameras[i], to_world);
    }
    for (unsigned i = 0; i < scene_.mNumLights; ++i) {
      if (scene_.mLights[i]->mName == node.mName) add_light(*scene_.mLights[i], to_world);
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) visit(*node.mChildren[i], to_world);
  }

  void add_mesh(const aiMesh& source, const Transform& to_world) {
    if (source.mPrimitiveTypes & (aiPrimitiveType_POINT | aiPrimitiveType_LINE)) {
      notes_.add("points or lines, left out");
    }
    if (source.HasBones()) notes_.add("skin: the mesh is shown as it was modelled");
    if (source.HasVertexColors(0)) notes_.add("mesh with colours at its vertices, not used");
    Geometry mesh;
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
      mesh.positions.push_back(vector_of(source.mVertices[i]));
      mesh.normals.push_back(source.HasNormals() ? unit_or_zero(vector_of(source.mNormals[i])) : Vec3{0, 0, 0});
      const bool has_uv = source.HasTextureCoords(0);
      mesh.uvs.push_back(has_uv ? Vec2{source.mTextureCoords[0][i].x, source.mTextureCoords[0][i].y} : Vec2{});
    }
    for (unsigned i = 0; i < source.mNumFaces; ++i) {
      const aiFace& face = source.mFaces[i];
      if (face.mNumIndices == 3) mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
    }
    merge_identical_vertices(mesh);
    notes_.add("triangle wound against its normals, turned round", wind_by_normals(mesh));
    transform_mesh(mesh, to_world);
    triangles_.grow(scene_bytes(mesh));
    const std::uint32_t material = source.mMaterialIndex;
    append_counted(description_.geometry, mesh, path_ + ": " + source.mName.C_Str(), material, emissions_.at(material),
                   notes_);
  }

  static Vec3 unit_or_zero(Vec3 n) {
    const float l = length(n);
    return l > 0 && std::isfinite(l) ? n / l : Vec3{0, 0, 0};
  }

  void add_camera(const aiCamera& source, const Transform& to_world) {
    Camera camera;
    camera.name = source.mName.C_Str();
    const Vec3 forward = unit_or_zero(to_world.vector(vector_of(source.mLookAt)));
    const Vec3 right = unit_or_zero(cross(forward, to_world.vector(vector_of(source.mUp))));
    if (length_squared(right) == 0) {
      notes_.add("camera '" + camera.name + "' has no direction, left out");
      return;
    }
    camera.to_world = {right, cross(right, forward), forward, to_world.point(vector_of(source.mPosition))};
    const float shorter = source.mAspect > 1 ? 1 / source.mAspect : 1;  // Assimp's angles and widths are horizontal
    if (source.mOrthographicWidth > 0) {
      camera.kind = CameraKind::orthographic;
      camera.half_extent = source.mOrthographicWidth * shorter;
    } else {
      camera.half_extent = std::tan(std::clamp(source.mHorizontalFOV, 0.001f, 1.57f)) * shorter;
    }
    description_.cameras.push_back(std::move(camera));
  }

  void add_light(const aiLight& source, const Transform& to_world) {
    Light light;
    light.name = source.mName.C_Str();
    light.intensity = {source.mColorDiffuse.r, source.mColorDiffuse.g, source.mColorDiffuse.b};
    light.position = to_world.point(vector_of(source.mPosition));
    light.direction = unit_or_zero(to_world.vector(vector_of(source.mDirection)));
    const bool needs_direction = source.mType != aiLightSource_POINT;
    if (source.mType == aiLightSource_POINT) {
      light.kind = LightKind::point;
    } else if (source.mType == aiLightSource_SPOT) {
      light.kind = LightKind::spot;
      light.cos_inner = std::cos(source.mAngleInnerCone / 2);
      light.cos_outer = std::min(std::cos(source.mAngleOuterCone / 2), light.cos_inner);
    } else if (source.mType == aiLightSource_DIRECTIONAL) {
      light.kind = LightKind::directional;
    } else {
      notes_.add("area or ambient light, left out");
      return;
    }
    if (needs_direction && length_squared(light.direction) == 0) {
      notes_.add("light '" + light.name + "' has no direction, left out");
      return;
    }
    notes_.add("light intensity of a file without units, taken as W sr^-1 (or W m^-2)");
    description_.lights.push_back(std::move(light));
  }

  const aiScene& scene_;
  const std::string& path_;
  NoteCounter& notes_;
  Reservation triangles_;
  TextureCache textures_;
  SceneDescription description_;
  std::vector<std::uint32_t> emissions_;  ///< of each material
};

}  // namespace

SceneDescription load_assimp(const std::string& path, const ImportOptions& options) {
  NoteCounter notes;
  unsigned steps = aiProcess_Triangulate;
  Assimp::Importer importer;
  if (std::filesystem::path(path).extension() == ".obj" || std::filesystem::path(path).extension() == ".OBJ") {
    const ObjScan scan = scan_obj(path, notes);
    if (scan.has_smoothing_groups && !scan.has_normals) {
      steps |= aiProcess_GenSmoothNormals;
      importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, 60.0f);
      notes.add("smoothing groups without normals: edges under 60 degrees are made smooth");
    }
  }
  const aiScene* scene = importer.ReadFile(path, steps);
  if (!scene) {
    throw Error({path}, std::string("cannot be read: ") + importer.GetErrorString(),
                "Open it in the program that wrote it and export it anew, as glTF if possible.");
  }
  SceneDescription description = AssimpBuilder(*scene, path, options, notes).build();
  if (description.geometry.triangles.empty()) {
    throw Error({path}, "has no triangles that can be shown", "Export meshes, not curves or points.");
  }
  notes.write_to(description.notes);
  return description;
}

bool assimp_reads(const std::string& extension) { return Assimp::Importer().IsExtensionSupported(extension); }

}  // namespace glowworm
