#include "gltf_writer/scene_glb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "bake/source_texture.h"
#include "core/error.h"
#include "core/log.h"
#include "core/version.h"
#include "gltf_writer/glb.h"
#include "gltf_writer/gltf_glb.h"
#include "gltf_writer/light_writer.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr const char* kSpecular = "KHR_materials_specular";

json triple(RGB c) { return {c.r, c.g, c.b}; }

/// The vertices of one primitive, each once.
class PrimitiveVertices {
 public:
  std::uint32_t add(Vec3 position, Vec3 normal, Vec2 uv, Vec2 light_uv) {
    const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
    const std::array<std::uint32_t, 10> key{bits(position.x), bits(position.y), bits(position.z), bits(normal.x),
                                            bits(normal.y),   bits(normal.z),   bits(uv.x),       bits(uv.y),
                                            bits(light_uv.x), bits(light_uv.y)};
    const auto [found, is_new] = index_.emplace(key, static_cast<std::uint32_t>(positions.size()));
    if (is_new) {
      positions.push_back(position);
      normals.push_back(normal);
      uvs.push_back(uv);
      light_uvs.push_back(light_uv);
    }
    return found->second;
  }

  std::vector<Vec3> positions, normals;
  std::vector<Vec2> uvs, light_uvs;
  std::vector<std::uint32_t> indices;

 private:
  std::map<std::array<std::uint32_t, 10>, std::uint32_t> index_;
};

/// A triangle of the file.
struct OutputFace {
  BakeFace face;
  std::uint32_t chart = kNone, place = 0;  ///< its chart and its index there; kNone: not baked
};

bool is_gltf(const GltfParts* origin) { return origin && !origin->path.empty(); }

/// Key of a primitive: object, material, emission, layer of light (-1: not baked), one side.
using PrimitiveKey = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, int, bool>;

class SceneWriter {
 public:
  SceneWriter(const Scene& scene, const BakeLayout& layout, const EncodedLight& light, BakeFormat format,
              const BakeNotes& notes)
      : scene_(scene), layout_(layout), format_(format), light_(layout, light, format, notes) {}

  std::string write() {
    file_.json["asset"]["generator"] = fmt::format("glowworm {}", version());
    file_.json["asset"]["extras"] = {{"glowworm", light_.description()}};
    light_.add_textures(file_);
    write_objects();
    write_cameras();
    for (int i = 0; i < static_cast<int>(file_.json["nodes"].size()); ++i) roots_.push_back(i);
    if (const Vec3 o = scene_.origin(); !(o == Vec3{0, 0, 0}))
      roots_ = {file_.add("nodes", {{"name", scene_.name()}, {"translation", {o.x, o.y, o.z}}, {"children", roots_}})};
    file_.add("scenes", {{"name", scene_.name()}, {"nodes", roots_}});
    file_.json["scene"] = 0;
    return file_.content();
  }

 private:
  /// A colour of the file: a reference to a texture, null if there is none, and a factor.
  struct Picture {
    json texture;
    RGB factor;
  };

  bool is_unlit() const { return format_ == BakeFormat::unlit || format_ == BakeFormat::vertex; }

  /// All faces of the scene: the baked sides, and the fronts of what was not baked.
  std::map<PrimitiveKey, std::vector<OutputFace>> faces() const {
    const Geometry& g = scene_.geometry();
    std::map<PrimitiveKey, std::vector<OutputFace>> out;
    std::vector<std::uint8_t> sides(g.triangle_count(), 0);
    for (const BakeFace& face : layout_.faces) sides[face.triangle] |= face.back ? 2 : 1;
    for (std::uint32_t c = 0; c < layout_.charts.size(); ++c)
      for (std::uint32_t i = 0; i < layout_.charts[c].faces.size(); ++i) {
        const BakeFace face = layout_.faces[layout_.charts[c].faces[i]];
        const std::uint32_t t = face.triangle;
        const bool one_sided = sides[t] == 3 || is_one_sided(t);
        const bool glows = g.emission[t] != kNone && (!face.back || scene_.emissions()[g.emission[t]].two_sided);
        const std::uint32_t emission = glows ? g.emission[t] : kNone;
        out[{g.object_of(t), g.material[t], emission, light_.layer_of(c), one_sided}].push_back({face, c, i});
      }
    for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
      if (sides[t] != 0) continue;
      out[{g.object_of(t), g.material[t], g.emission[t], -1, is_one_sided(t)}].push_back({{t, false}, kNone, 0});
    }
    return out;
  }

  bool is_one_sided(std::uint32_t triangle) const {
    const std::uint32_t emission = scene_.geometry().emission[triangle];
    if (emission != kNone) return !scene_.emissions()[emission].two_sided;
    return material_of(triangle).single_sided;
  }

  const Material& material_of(std::uint32_t triangle) const {
    return scene_.materials()[scene_.geometry().material[triangle]];
  }

  void write_objects() {
    std::map<std::uint32_t, json> meshes;
    for (const auto& [key, faces] : faces()) meshes[std::get<0>(key)].push_back(primitive(key, faces));
    for (auto& [object, primitives] : meshes) {
      const std::string name = object != kNone ? scene_.geometry().objects[object].name : scene_.name();
      const int mesh = file_.add("meshes", {{"name", name}, {"primitives", primitives}});
      file_.add("nodes", {{"name", name}, {"mesh", mesh}});
    }
  }

  json primitive(const PrimitiveKey& key, const std::vector<OutputFace>& faces) {
    const Geometry& g = scene_.geometry();
    const int number = material(key, faces.front().face.triangle);
    const bool has_own_uvs = uses_first_uvs(file_.json["materials"][static_cast<std::size_t>(number)]);
    PrimitiveVertices v;
    for (const OutputFace& f : faces) {
      const auto& corners = g.triangles[f.face.triangle];
      const Vec3 flat = face_normal(g, f.face);
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t c = f.face.back ? 2 - i : i;
        const std::uint32_t vertex = corners[c];
        const Vec3 own = g.normals[vertex];
        const Vec3 n = length_squared(own) > 0 ? face_forward(normalize(own), flat) : flat;
        v.indices.push_back(v.add(g.positions[vertex], n, has_own_uvs ? g.uvs[vertex] : Vec2{}, light_uv(f, c)));
      }
    }
    json attributes = {{"POSITION", file_.add_vectors(v.positions, true)},
                       {"NORMAL", file_.add_vectors(v.normals, false)}};
    if (has_own_uvs) {
      for (Vec2& uv : v.uvs) uv.y = 1 - uv.y;
      attributes["TEXCOORD_0"] = file_.add_pairs(v.uvs);
    }
    if (const int layer = std::get<3>(key); layer >= 0 && format_ == BakeFormat::vertex)
      attributes["COLOR_0"] = file_.add_vectors(colors_at(v.light_uvs, layer), false);
    else if (layer >= 0)
      attributes["TEXCOORD_1"] = file_.add_pairs(v.light_uvs);
    // Sets of coordinates count from 0, so one accessor serves as both.
    if (attributes.contains("TEXCOORD_1") && !has_own_uvs) attributes["TEXCOORD_0"] = attributes["TEXCOORD_1"];
    return {{"attributes", attributes}, {"indices", file_.add_indices(v.indices)}, {"material", number}};
  }

  /// Whether the base colour or the light of a material is a texture of the scene.
  static bool uses_first_uvs(const json& material) {
    const auto uses = [](const json& textures, const char* name) {
      return textures.contains(name) && textures[name].value("texCoord", 0) == 0;
    };
    return uses(material["pbrMetallicRoughness"], "baseColorTexture") || uses(material, "emissiveTexture");
  }

  Vec2 light_uv(const OutputFace& f, std::size_t corner) const {
    return f.chart == kNone ? Vec2{0, 0} : light_.uv(f.chart, f.place, corner);
  }

  std::vector<Vec3> colors_at(std::span<const Vec2> uvs, int layer) const {
    std::vector<Vec3> out;
    for (const Vec2 uv : uvs) out.push_back(light_.color_at(uv, layer));
    return out;
  }

  /// @param triangle with this key
  int material(const PrimitiveKey& key, std::uint32_t triangle) {
    auto own = key;
    std::get<0>(own) = 0;  // Objects share materials.
    const auto found = materials_.find(own);
    if (found != materials_.end()) return found->second;
    const auto [object, source, emission, layer, one_sided] = key;
    const Material& m = scene_.materials()[source];
    json out = layer >= 0 ? baked(triangle, layer, emission) : emission != kNone ? lamp(m, emission) : plain(triangle);
    if (!m.name.empty()) out["name"] = m.name;
    if (!one_sided) out["doubleSided"] = true;
    return materials_[own] = file_.add("materials", std::move(out));
  }

  /// Black, without reflections.
  static json black() {
    return {
        {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
        {"extensions", {{kSpecular, {{"specularFactor", 0}}}}}};
  }

  json lamp(const Material& m, std::uint32_t emission) {
    json out;
    if (is_unlit()) {
      const Picture& shown = glow(emission);
      out = unlit(shown.factor);
      if (!shown.texture.is_null()) out["pbrMetallicRoughness"]["baseColorTexture"] = shown.texture;
    } else {
      out = black();
      add_glow(emission, out);
    }
    if (has_even_alpha(m)) add_alpha(m, out);
    return out;
  }

  /// Makes a material emit.
  void add_glow(std::uint32_t emission, json& material) {
    const Picture& shown = glow(emission);
    const float most = max_component(shown.factor);
    if (!(most > 0)) return;
    material["emissiveFactor"] = triple(shown.factor / most);
    if (!shown.texture.is_null()) material["emissiveTexture"] = shown.texture;
    material["extensions"][kEmissiveStrength] = {{"emissiveStrength", most}};
  }

  /// Emitted radiance in the units of the file.
  const Picture& glow(std::uint32_t emission) {
    const Emission& source = scene_.emissions()[emission];
    return picture({source.radiance.value * light_.gain(), source.radiance.texture}, {}, emission, source.name);
  }

  static json unlit(RGB color) {
    const RGB shown = clamp(color, 0, 1);
    return {{"pbrMetallicRoughness", {{"baseColorFactor", {shown.r, shown.g, shown.b, 1}}}},
            {"extensions", {{kUnlit, json::object()}}}};
  }

  json baked(std::uint32_t triangle, int layer, std::uint32_t emission) {
    const bool shows_base = format_ == BakeFormat::lightmap || format_ == BakeFormat::vertex;
    json out = plain(triangle, shows_base || material_of(triangle).alpha.texture != kNone);
    light_.light_material(out, layer, 1);
    if (format_ == BakeFormat::lightmap && emission != kNone) add_glow(emission, out);
    return out;
  }

  /// A material that was not baked, or whose base colour is kept.
  json plain(std::uint32_t triangle, bool textured = true) {
    const Material& m = material_of(triangle);
    const RGB c = base_factor(scene_, triangle);
    const float roughness = std::sqrt(std::clamp(std::max(m.roughness_u.value, m.roughness_v.value), 0.0f, 1.0f));
    json pbr = {{"baseColorFactor", {c.r, c.g, c.b, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 1}};
    json extensions = json::object();
    switch (m.kind) {
      case MaterialKind::conductor:
      case MaterialKind::coated_conductor:
        pbr["metallicFactor"] = 1;
        pbr["roughnessFactor"] = roughness;
        break;
      case MaterialKind::dielectric:
      case MaterialKind::thin_dielectric:
      case MaterialKind::interface:
        pbr["roughnessFactor"] = roughness;
        extensions["KHR_materials_transmission"] = {{"transmissionFactor", 1}};
        extensions["KHR_materials_ior"] = {{"ior", m.kind == MaterialKind::interface ? 1 : m.ior}};
        break;
      case MaterialKind::metallic_roughness:
        pbr["metallicFactor"] = std::clamp(m.metallic.value, 0.0f, 1.0f);
        pbr["roughnessFactor"] = roughness;
        if (m.transmission.value > 0)
          extensions["KHR_materials_transmission"] = {{"transmissionFactor", std::min(m.transmission.value, 1.0f)}};
        break;
      default:
        extensions[kSpecular] = {{"specularFactor", 0}};
    }
    json out = {{"pbrMetallicRoughness", pbr}};
    if (!extensions.empty()) out["extensions"] = extensions;
    if (textured) add_source_texture(m, out);
    if (has_even_alpha(m)) add_alpha(m, out);
    return out;
  }

  /// Adds the texture of the base colour and alpha, where there is one. Materials share it, so it has no factors.
  void add_source_texture(const Material& m, json& out) {
    const FloatInput alpha{1.0f, m.alpha.texture, m.alpha.channel};
    const Picture& base = picture({RGB(1.0f), base_input(m).texture}, alpha, kNone, m.name);
    if (base.texture.is_null()) return;
    out["pbrMetallicRoughness"]["baseColorTexture"] = base.texture;
    if (m.alpha.texture != kNone) add_alpha(m, out);
  }

  /// Whether a surface is as transparent everywhere, by no texture.
  static bool has_even_alpha(const Material& m) { return m.alpha.texture == kNone && m.alpha.value < 1; }

  /// Makes a material transparent, by the factor of its alpha.
  static void add_alpha(const Material& m, json& out) {
    out["pbrMetallicRoughness"]["baseColorFactor"][3] = std::clamp(m.alpha.value, 0.0f, 1.0f);
    out["alphaMode"] = m.alpha_cutoff >= 0 ? "MASK" : "BLEND";
    if (m.alpha_cutoff >= 0) out["alphaCutoff"] = m.alpha_cutoff;
  }

  /// @param emission whose radiance the colour is; kNone: it is a base colour
  const Picture& picture(const ColorInput& color, const FloatInput& alpha, std::uint32_t emission,
                         const std::string& name) {
    const std::array<std::uint32_t, 3> key{color.texture, alpha.texture, emission};
    const auto [found, is_new] = pictures_.try_emplace(key);
    Picture& out = found->second;
    if (!is_new) return out;
    out.factor = color.value;
    const bool ends_at_one = emission == kNone || is_unlit();
    const std::optional<SourceTexture> source = source_texture(scene_, color, alpha, ends_at_one ? 1.0f : 0.0f);
    if (!source) return out;
    out.factor = RGB(source->white);
    out.texture["index"] = file_.add_texture(source->png, name, true);
    if (source->is_transformed())
      out.texture["extensions"]["KHR_texture_transform"] = {{"offset", {source->offset.x, source->offset.y}},
                                                            {"scale", {source->scale.x, source->scale.y}}};
    return out;
  }

  void write_cameras() {
    for (const Camera& camera : scene_.cameras()) {
      const Transform& t = camera.to_world;
      const int index = file_.add("cameras", projection(camera));
      // glTF's cameras look along -z; a mirrored one has no place there.
      const Vec3 x = normalize(cross(t.y, -t.z));
      file_.add("nodes", {{"name", camera.name},
                          {"camera", index},
                          {"matrix",
                           {x.x, x.y, x.z, 0, t.y.x, t.y.y, t.y.z, 0, -t.z.x, -t.z.y, -t.z.z, 0, t.translation.x,
                            t.translation.y, t.translation.z, 1}}});
    }
  }

  /// A camera without its place. Only the size of its window is kept: glTF's are around the axis.
  json projection(const Camera& camera) const {
    const FilmRequest& film = scene_.film();
    const ScreenWindow window = screen_window(camera, film.width, film.height);
    const float x = std::abs(window.right - window.left) / 2, y = std::abs(window.top - window.bottom) / 2;
    const float radius = std::max(scene_.radius(), 1e-6f);
    if (camera.kind == CameraKind::orthographic)
      return {{"type", "orthographic"},
              {"name", camera.name},
              {"orthographic", {{"xmag", x}, {"ymag", y}, {"znear", 0}, {"zfar", 100 * radius}}}};
    json lens = {{"yfov", 2 * std::atan(y)}, {"znear", 0.001 * radius}};
    // Without a film, only a window of the camera's own has a shape.
    if (film.width > 0 || x != y) lens["aspectRatio"] = x / y;
    return {{"type", "perspective"}, {"name", camera.name}, {"perspective", lens}};
  }

  const Scene& scene_;
  const BakeLayout& layout_;
  BakeFormat format_;
  LightWriter light_;
  GlbFile file_;
  std::vector<int> roots_;
  std::map<PrimitiveKey, int> materials_;
  std::map<std::array<std::uint32_t, 3>, Picture> pictures_;  ///< by the nodes of colour and alpha, and the emission
};

}  // namespace

void check_outside_files(const std::vector<std::string>& files, const GltfParts* gltf, const std::string& option) {
  std::vector<std::string> images, others;
  for (const std::string& file : files)
    (is_gltf(gltf) && !gltf->data_files.contains(file) ? images : others).push_back(file);
  const auto list = [](const std::vector<std::string>& names) {
    const std::string more = names.size() > 1 ? fmt::format(" and {} more", names.size() - 1) : "";
    return fmt::format("'{}'{}", names.front(), more);
  };
  if (!others.empty())
    throw Error("the scene names files outside its folder, which the bake would copy: " + list(others),
                fmt::format("Put them into the folder. If you trust the scene, give {}.", option));
  if (!images.empty())
    inform(
        fmt::format("note: the bake names images outside the scene's folder and does not copy them: {}. If you "
                    "trust the scene, give {} to copy them",
                    list(images), option));
}

std::vector<std::string> bake_format_names() { return {"emissive", "unlit", "lightmap", "vertex"}; }

TexelLight quantity_of(BakeFormat format) {
  if (format == BakeFormat::vertex) return TexelLight::tint;
  return format == BakeFormat::lightmap ? TexelLight::irradiance : TexelLight::radiance;
}

ShownLight shown_light(BakeFormat format, const GltfParts* gltf) { return {quantity_of(format), is_gltf(gltf)}; }

LightRange range_of(const Scene& scene, const BakeLayout& layout, BakeFormat format, float exposure) {
  LightRange out;
  out.white = (quantity_of(format) == TexelLight::radiance ? 1 : kPi) / std::exp2(exposure);
  if (format == BakeFormat::vertex || format == BakeFormat::unlit) out.scale = out.white;
  if (format == BakeFormat::lightmap)
    out.albedo = [&scene, &layout](std::size_t texel) {
      const std::uint32_t triangle = layout.faces[layout.texels.face[texel]].triangle;
      return max_component(base_color(scene, triangle, layout.texels.barycentric[texel], true));
    };
  return out;
}

std::string glb_of_scene(const Scene& scene, const BakeLayout& layout, const EncodedLight& light, BakeFormat format,
                         const BakeNotes& notes) {
  if (is_gltf(notes.gltf.get())) return glb_of_gltf(layout, light, format, notes);
  return SceneWriter(scene, layout, light, format, notes).write();
}

}  // namespace glowworm
