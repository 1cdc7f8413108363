// glowworm-assimp: reads a scene file by Assimp and writes it to a pipe. Assimp may crash on damaged or malicious
// files, so this is a separate process with limits.
// usage: glowworm-assimp FILE MEMORY_BYTES CPU_SECONDS
#include <assimp/DefaultIOSystem.h>
#include <assimp/commonMetaData.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/confine.h"
#include "import/assimp/hand_over.h"
#include "import/mesh_tools.h"

namespace glowworm {
namespace {

/// Opens only regular files, because others may block forever, and lists them.
class RegularFiles final : public Assimp::DefaultIOSystem {
 public:
  explicit RegularFiles(std::vector<std::string>& opened) : opened_(opened) {}
  bool Exists(const char* file) const override {
    std::error_code error;
    return std::filesystem::is_regular_file(file, error);
  }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (!Exists(file)) return nullptr;
    opened_.emplace_back(file);
    return Assimp::DefaultIOSystem::Open(file, mode);
  }

 private:
  std::vector<std::string>& opened_;
};

Vec3 vector_of(const aiVector3D& v) { return {v.x, v.y, v.z}; }

TransformDouble transform_of(const aiMatrix4x4& m) {
  return {{m.a1, m.b1, m.c1}, {m.a2, m.b2, m.c2}, {m.a3, m.b3, m.c3}, {m.a4, m.b4, m.c4}};
}

TextureWrap wrap_of(int mode) {
  switch (mode) {
    case aiTextureMapMode_Clamp:
    case aiTextureMapMode_Decal:
      return TextureWrap::clamp;
    case aiTextureMapMode_Mirror:
      return TextureWrap::mirror;
    default:
      return TextureWrap::repeat;
  }
}

/// Converts a scene of Assimp.
class Collector {
 public:
  explicit Collector(const aiScene& scene) : scene_(scene) {}

  ForeignScene collect() {
    for (unsigned i = 0; i < scene_.mNumTextures; ++i) {
      const aiTexture& texture = *scene_.mTextures[i];
      std::string& bytes = out_.embedded.emplace_back();  // stays empty for raw pixels, which no reader in use produces
      if (texture.mHeight == 0) bytes.assign(reinterpret_cast<const char*>(texture.pcData), texture.mWidth);
    }
    for (unsigned i = 0; i < scene_.mNumMaterials; ++i) out_.materials.push_back(material_of(*scene_.mMaterials[i]));
    for (unsigned i = 0; i < scene_.mNumMeshes; ++i) out_.meshes.push_back(mesh_of(*scene_.mMeshes[i]));
    for (unsigned i = 0; i < scene_.mNumCameras; ++i) cameras_.emplace(scene_.mCameras[i]->mName.C_Str(), i);
    for (unsigned i = 0; i < scene_.mNumLights; ++i) lights_.emplace(scene_.mLights[i]->mName.C_Str(), i);
    visit_nodes();
    out_.animations = scene_.mNumAnimations;
    return std::move(out_);
  }

 private:
  /// Visits parents before children, and children in order. Not recursive, because trees may be deep.
  void visit_nodes() {
    std::vector<std::pair<const aiNode*, TransformDouble>> pending;
    if (scene_.mRootNode) pending.emplace_back(scene_.mRootNode, TransformDouble{});
    while (!pending.empty()) {
      const auto [node, parent] = pending.back();
      pending.pop_back();
      const TransformDouble to_world = parent * transform_of(node->mTransformation);
      for (unsigned i = 0; i < node->mNumMeshes; ++i) out_.instances.push_back({node->mMeshes[i], to_world});
      const std::string name = node->mName.C_Str();
      for (auto [at, last] = cameras_.equal_range(name); at != last; ++at)
        add_camera(*scene_.mCameras[at->second], to_world);
      for (auto [at, last] = lights_.equal_range(name); at != last; ++at)
        add_light(*scene_.mLights[at->second], to_world);
      for (unsigned i = node->mNumChildren; i-- > 0;) pending.emplace_back(node->mChildren[i], to_world);
    }
  }

  PhongMaterial material_of(const aiMaterial& source) const {
    PhongMaterial m;
    m.name = source.GetName().C_Str();
    m.diffuse = RGB(kDefaultAlbedo);
    const bool has_color = color(source, AI_MATKEY_COLOR_DIFFUSE, m.diffuse);
    // Assimp paints what has no material in a grey of its own.
    if ((m.name.empty() || m.name == AI_DEFAULT_MATERIAL_NAME) && m.diffuse == RGB(0.6f))
      m.diffuse = RGB(kDefaultAlbedo);
    color(source, AI_MATKEY_COLOR_SPECULAR, m.specular);
    color(source, AI_MATKEY_COLOR_EMISSIVE, m.emissive);
    color(source, AI_MATKEY_COLOR_TRANSPARENT, m.filter);
    source.Get(AI_MATKEY_SHININESS, m.exponent);
    source.Get(AI_MATKEY_OPACITY, m.opacity);
    source.Get(AI_MATKEY_REFRACTI, m.ior);
    m.model = -1;
    source.Get("$mat.illum", 0, 0, m.model);
    float factor = 0;
    if (source.Get(AI_MATKEY_METALLIC_FACTOR, factor) == aiReturn_SUCCESS) m.metallic = factor;
    if (source.Get(AI_MATKEY_ROUGHNESS_FACTOR, factor) == aiReturn_SUCCESS) m.roughness = factor;
    m.has_metal_maps =
        source.GetTextureCount(aiTextureType_METALNESS) + source.GetTextureCount(aiTextureType_DIFFUSE_ROUGHNESS) > 0;
    m.diffuse_map = texture_of(source, aiTextureType_DIFFUSE);
    if (m.diffuse_map.name.empty()) m.diffuse_map = texture_of(source, aiTextureType_BASE_COLOR);
    // A texture without a colour is taken whole. Collada gives one or the other, and Assimp then makes up a colour.
    if (!m.diffuse_map.name.empty() && (!has_color || is_collada())) m.diffuse = RGB(1.0f);
    m.opacity_map = texture_of(source, aiTextureType_OPACITY);
    m.emissive_map = texture_of(source, aiTextureType_EMISSIVE);
    m.normal_map = texture_of(source, aiTextureType_NORMALS);
    return m;
  }

  bool is_collada() const {
    aiString format;
    return scene_.mMetaData && scene_.mMetaData->Get(AI_METADATA_SOURCE_FORMAT, format) &&
           std::string_view(format.C_Str()).starts_with("Collada");
  }

  /// Returns whether the material gives the colour.
  static bool color(const aiMaterial& source, const char* key, unsigned type, unsigned index, RGB& value) {
    aiColor3D c(value.r, value.g, value.b);
    if (source.Get(key, type, index, c) != aiReturn_SUCCESS) return false;
    value = {c.r, c.g, c.b};
    return true;
  }

  PhongTexture texture_of(const aiMaterial& source, aiTextureType type) const {
    PhongTexture texture;
    aiString name;
    if (source.Get(AI_MATKEY_TEXTURE(type, 0), name) != aiReturn_SUCCESS) return texture;
    int mode_u = aiTextureMapMode_Wrap, mode_v = aiTextureMapMode_Wrap, uv_set = 0;
    source.Get(AI_MATKEY_MAPPINGMODE_U(type, 0), mode_u);
    source.Get(AI_MATKEY_MAPPINGMODE_V(type, 0), mode_v);
    source.Get(AI_MATKEY_UVWSRC(type, 0), uv_set);
    texture.name = name.C_Str();
    texture.wrap_u = wrap_of(mode_u);
    texture.wrap_v = wrap_of(mode_v);
    texture.by_second_uvs = uv_set != 0;
    const int embedded = scene_.GetEmbeddedTextureAndIndex(name.C_Str()).second;
    if (embedded >= 0) texture.embedded = static_cast<std::uint32_t>(embedded);
    return texture;
  }

  static ForeignMesh mesh_of(const aiMesh& source) {
    ForeignMesh mesh;
    mesh.name = source.mName.C_Str();
    mesh.material = source.mMaterialIndex;
    mesh.has_points_or_lines = (source.mPrimitiveTypes & (aiPrimitiveType_POINT | aiPrimitiveType_LINE)) != 0;
    mesh.has_bones = source.HasBones();
    mesh.has_colors = source.HasVertexColors(0);
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
      mesh.positions.push_back(vector_of(source.mVertices[i]));
      if (source.HasNormals()) mesh.normals.push_back(vector_of(source.mNormals[i]));
      if (source.HasTextureCoords(0)) {
        mesh.uvs.push_back({source.mTextureCoords[0][i].x, source.mTextureCoords[0][i].y});
      }
    }
    for (unsigned i = 0; i < source.mNumFaces; ++i) {
      const aiFace& face = source.mFaces[i];
      if (face.mNumIndices == 3) mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
    }
    return mesh;
  }

  void add_camera(const aiCamera& source, const TransformDouble& to_world) {
    ForeignCamera camera;
    camera.name = source.mName.C_Str();
    camera.to_world = to_world;
    camera.position = vector_of(source.mPosition);
    camera.look_at = vector_of(source.mLookAt);
    camera.up = vector_of(source.mUp);
    camera.aspect = source.mAspect;
    camera.horizontal_fov = source.mHorizontalFOV;
    camera.orthographic_width = source.mOrthographicWidth;
    out_.cameras.push_back(std::move(camera));
  }

  void add_light(const aiLight& source, const TransformDouble& to_world) {
    ForeignLight light;
    light.name = source.mName.C_Str();
    light.to_world = to_world;
    light.kind = source.mType == aiLightSource_POINT         ? ForeignLightKind::point
                 : source.mType == aiLightSource_SPOT        ? ForeignLightKind::spot
                 : source.mType == aiLightSource_DIRECTIONAL ? ForeignLightKind::directional
                                                             : ForeignLightKind::other;
    light.intensity = {source.mColorDiffuse.r, source.mColorDiffuse.g, source.mColorDiffuse.b};
    light.position = vector_of(source.mPosition);
    light.direction = vector_of(source.mDirection);
    light.inner_angle = source.mAngleInnerCone;
    light.outer_angle = source.mAngleOuterCone;
    out_.lights.push_back(std::move(light));
  }

  const aiScene& scene_;
  ForeignScene out_;
  std::multimap<std::string, unsigned> cameras_, lights_;  ///< by name of their node
};

void run(const char* file) {
  std::vector<std::string> opened;
  Assimp::Importer importer;
  importer.SetIOHandler(new RegularFiles(opened));  // the importer deletes it
  const aiScene* scene = importer.ReadFile(file, aiProcess_Triangulate);
  if (!scene) {
    const std::string reason = importer.GetErrorString();
    send_to_parent(reason.data(), reason.size());
    end_child(ChildExit::refused);
  }
  ForeignScene collected = Collector(*scene).collect();
  collected.files = std::move(opened);
  write_foreign_scene(collected, send_to_parent);
}

}  // namespace
}  // namespace glowworm

int main(int argc, char** argv) {
  glowworm::read_for_parent(argc, argv, 4, [&] { glowworm::run(argv[1]); });
}
