#include "gltf_writer/gltf_glb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "core/error.h"
#include "gltf_writer/gltf_file.h"
#include "gltf_writer/gltf_prune.h"
#include "gltf_writer/gltf_vertices.h"
#include "gltf_writer/light_writer.h"
#include "import/gltf/mesh.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
constexpr const char* kLights = "KHR_lights_punctual";
constexpr const char* kVariants = "KHR_materials_variants";

/// A chart and the number of a face there.
struct FaceInChart {
  std::uint32_t chart = kNone, face = 0;
};

/// What triangles of a primitive show: both sides alike, or one side of two.
enum class Shown { both, front, back };

/// A primitive of the file that shows light, and needs a material for it.
struct LitPrimitive {
  std::size_t mesh = 0, primitive = 0;
};

/// Key of a material: the source's (-1: none), layer of light, whether the back is hidden, set of coordinates.
using MaterialKey = std::tuple<int, int, bool, int>;

/// A member that is an index; -1 where there is none.
int index_member(const json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  return found != object.end() && found->is_number_integer() ? found->get<int>() : -1;
}

void erase_extension(json& object, const char* name) {
  if (!object.contains("extensions")) return;
  object["extensions"].erase(name);
  if (object["extensions"].empty()) object.erase("extensions");
}

void erase_value(json& list, const std::string& value) {
  if (list.is_array()) list.erase(std::remove(list.begin(), list.end(), json(value)), list.end());
}

/// Whether a texture of a material is placed by a set of texture coordinates.
bool uses_set(const json& material, int set) {
  for (const auto& [key, value] : material.items()) {
    if (key == "texCoord" && value == set) return true;
    if (key != "extras" && key != "MOZ_lightmap" && value.is_structured() && uses_set(value, set)) return true;
  }
  return false;
}

/// Calls `use` with each primitive of a file.
template <typename Json, typename Use>
void for_each_primitive(Json& file, const Use& use) {
  for (std::size_t m = 0; m < file["meshes"].size(); ++m)
    for (std::size_t p = 0; p < file["meshes"][m]["primitives"].size(); ++p)
      use(m, p, file["meshes"][m]["primitives"][p]);
}

class GltfWriter {
 public:
  GltfWriter(const GltfDocument& document, json whole, const BakeLayout& layout, const EncodedLight& light,
             BakeFormat format, const BakeNotes& notes)
      : document_(document),
        layout_(layout),
        format_(format),
        notes_(notes),
        light_(layout, light, format, notes, document.light_units),
        file_(glb_of_document(document, std::move(whole), notes.allow_outside, notes.folder)),
        meshes_(file_.json["meshes"]),
        materials_(file_.json.value("materials", json::array())),
        references_(prunable(file_.json) ? references_in(file_.json) : GltfReferences()) {}

  std::string write() {
    check_parts();
    find_faces();
    light_.add_textures(file_);
    std::map<std::pair<int, int>, std::vector<const GltfPart*>> places;  // by node and instance
    for (const GltfPart& part : notes_.gltf->parts)
      if (is_lit(part)) places[{part.node, part.instance}].push_back(&part);
    std::set<int> lit_nodes;
    for (const auto& [place, parts] : places) lit_nodes.insert(place.first);
    for (std::size_t n = 0; n < file_.json["nodes"].size(); ++n)
      if (!lit_nodes.contains(static_cast<int>(n)))
        shared_with_dark_.insert(index_member(file_.json["nodes"][n], "mesh"));
    for (const auto& [place, parts] : places) {
      const std::size_t mesh = mesh_for(place.first, place.second, parts[0]->mesh);
      for (const GltfPart* part : parts) light_primitive(mesh, *part);
    }
    add_materials();
    scale_lights();
    prune(references_, file_);
    for (const char* name : {kDraco, kInstancing}) drop_unused(name);
    // Of textures that are left out, and of compressed views.
    for (const char* name : {"KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds",
                             "EXT_meshopt_compression", "KHR_meshopt_compression"})
      drop_unused(name);
    json& asset = file_.json["asset"];
    if (!asset.contains("extras") || asset["extras"].is_object()) asset["extras"]["glowworm"] = light_.description();
    return file_.content();
  }

 private:
  [[noreturn]] void fail_by_change() const {
    throw Error({document_.path}, "changed while it was baked", "Bake it again.");
  }

  /// Expects nodes, meshes and primitives of the parts.
  void check_parts() const {
    const json nodes = file_.json.value("nodes", json::array());
    for (const GltfPart& part : notes_.gltf->parts) {
      const auto n = static_cast<std::size_t>(part.node), m = static_cast<std::size_t>(part.mesh);
      if (n >= nodes.size() || index_member(nodes[n], "mesh") != part.mesh || m >= meshes_.size() ||
          part.primitive >= meshes_[m]["primitives"].size())
        fail_by_change();
    }
  }

  /// The faces of both sides of each triangle.
  void find_faces() {
    std::uint32_t end = 0;
    for (const GltfPart& part : notes_.gltf->parts) end = std::max(end, part.first_triangle + part.count);
    for (auto& side : faces_) side.resize(end);
    for (std::uint32_t c = 0; c < layout_.charts.size(); ++c)
      for (std::uint32_t i = 0; i < layout_.charts[c].faces.size(); ++i) {
        const BakeFace face = layout_.faces[layout_.charts[c].faces[i]];
        faces_[face.back ? 1 : 0][face.triangle] = {c, i};
      }
  }

  bool is_lit(const GltfPart& part) const {
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.count; ++t)
      if (faces_[0][t].chart != kNone || faces_[1][t].chart != kNone) return true;
    return false;
  }

  /// The mesh for the light of a node or of one of its instances: the file's own for the first where all its users
  /// have light, and copies for the others.
  std::size_t mesh_for(int node, int instance, int mesh) {
    std::size_t out = static_cast<std::size_t>(mesh);
    if (shared_with_dark_.contains(mesh) || !taken_.insert(mesh).second)
      out = static_cast<std::size_t>(file_.add("meshes", meshes_[static_cast<std::size_t>(mesh)]));
    json& own = file_.json["nodes"][static_cast<std::size_t>(node)];
    if (instance >= 0)
      add_instance(node, instance, out);
    else
      own["mesh"] = out;
    return out;
  }

  /// What a node says of its instances.
  struct Instances {
    json attributes;
    json child;  ///< what each of them has in common with the node
  };

  /// Makes a node one without a mesh, and so without a skin and weights of its own.
  static Instances take_instances(json& node) {
    Instances out{node["extensions"][kInstancing].value("attributes", json::object()), json::object()};
    for (const char* key : {"name", "skin", "weights"})
      if (node.contains(key)) out.child[key] = node[key];
    for (const char* key : {"mesh", "skin", "weights"}) node.erase(key);
    erase_extension(node, kInstancing);
    return out;
  }

  /// Makes an instance of a node its child.
  void add_instance(int node, int instance, std::size_t mesh) {
    const auto n = static_cast<std::size_t>(node);
    const auto [found, is_new] = instancing_.try_emplace(node);
    const Instances& instances = found->second;
    if (is_new) found->second = take_instances(file_.json["nodes"][n]);
    json child = instances.child;
    child["mesh"] = mesh;
    const auto set = [&](const char* attribute, const char* key, std::size_t components) {
      const int accessor = index_member(instances.attributes, attribute);
      if (accessor < 0) return;
      const std::vector<float> all = read_floats(document_, accessor, static_cast<int>(components));
      const auto first = all.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(instance) * components);
      std::vector<float> own(first, first + static_cast<std::ptrdiff_t>(components));
      if (components == 4) {
        const float l = std::sqrt(own[0] * own[0] + own[1] * own[1] + own[2] * own[2] + own[3] * own[3]);
        for (float& x : own) x /= l > 0 ? l : 1;
      }
      child[key] = own;
    };
    set("TRANSLATION", "translation", 3);
    set("ROTATION", "rotation", 4);
    set("SCALE", "scale", 3);
    const int index = file_.add("nodes", child);
    file_.json["nodes"][n]["children"].push_back(index);
  }

  /// Gives a primitive of a mesh the light of a part, as several primitives where its triangles lie in several layers
  /// or show two sides.
  void light_primitive(std::size_t mesh, const GltfPart& part) {
    const Geometry source = read_gltf_primitive(document_, part.mesh, part.primitive);
    if (source.triangles.size() != part.count + part.dropped.size()) fail_by_change();
    std::map<std::pair<int, Shown>, std::vector<std::array<std::uint32_t, 3>>> groups;
    LitVertices own(source.positions.size()), turned(source.positions.size());
    std::vector<std::array<std::uint32_t, 3>> dark;
    auto dropped = part.dropped.begin();
    std::uint32_t t = part.first_triangle;
    for (std::uint32_t i = 0; i < source.triangles.size(); ++i) {
      const auto& corners = source.triangles[i];
      if (dropped != part.dropped.end() && *dropped == i) {
        ++dropped;
        dark.push_back({own.add(corners[0]), own.add(corners[1]), own.add(corners[2])});
        continue;
      }
      const FaceInChart front = faces_[0][t], back = faces_[1][t];
      const bool two = front.chart != kNone && back.chart != kNone;
      if (front.chart != kNone) add_face(front, corners, part.mirrored, two ? Shown::front : Shown::both, own, groups);
      if (back.chart != kNone)
        add_face(back, corners, part.mirrored, two ? Shown::back : Shown::both, two ? turned : own, groups);
      ++t;
    }
    // Their entries equal `own`, but the first layer may be of backs alone.
    const auto front =
        std::find_if(groups.begin(), groups.end(), [](const auto& group) { return group.first.second != Shown::back; });
    if (front != groups.end()) front->second.insert(front->second.end(), dark.begin(), dark.end());
    write_groups(mesh, part, own, turned, groups);
  }

  template <typename Groups>
  void add_face(FaceInChart face, const std::array<std::uint32_t, 3>& corners, bool mirrored, Shown shown,
                LitVertices& vertices, Groups& groups) const {
    const int layer = light_.layer_of(face.chart);
    std::array<std::uint32_t, 3> entries{};
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t in_chart = mirrored ? (3 - c) % 3 : c;
      entries[c] = vertices.add(corners[c], light_.uv(face.chart, face.face, in_chart), layer);
    }
    if (shown == Shown::back) std::swap(entries[1], entries[2]);
    groups[{layer, shown}].push_back(entries);
  }

  template <typename Groups>
  void write_groups(std::size_t mesh, const GltfPart& part, LitVertices& own, LitVertices& turned,
                    const Groups& groups) {
    const json source = file_.json["meshes"][mesh]["primitives"][part.primitive];
    const int material = index_member(source, "material");
    AttributeWriter writer(document_, part.mesh, part.primitive, file_);
    own.arrange(false);
    turned.arrange(true);
    const int set = uv_set(source, material);
    const bool whole = groups.size() == 1 && own.unchanged() && !writer.is_compressed();
    json lit[2];
    bool is_first = true;
    for (const auto& [key, triangles] : groups) {
      const bool back = key.second == Shown::back;
      const LitVertices& vertices = back ? turned : own;
      json& attributes = lit[back];
      if (attributes.is_null()) attributes = attributes_for(source, material, vertices, set, back, writer);
      json primitive = source;
      primitive.update(attributes);
      if (writer.is_compressed()) erase_extension(primitive, kDraco);
      if (!whole) {
        primitive["indices"] = add_indices(vertices, triangles);
        primitive.erase("mode");
      }
      json& primitives = file_.json["meshes"][mesh]["primitives"];
      const std::size_t at = is_first ? part.primitive : primitives.size();
      lit_primitives_[{material, key.first, key.second != Shown::both, set}].push_back({mesh, at});
      if (is_first)
        primitives[at] = primitive;
      else
        primitives.push_back(primitive);
      is_first = false;
    }
  }

  int add_indices(const LitVertices& vertices, const std::vector<std::array<std::uint32_t, 3>>& triangles) {
    std::vector<std::uint32_t> indices;
    for (const auto& corners : triangles)
      for (const std::uint32_t entry : corners) indices.push_back(vertices.index(entry));
    return file_.add_indices(indices);
  }

  /// The set of coordinates for light: the second, or a further one where a texture uses that.
  int uv_set(const json& primitive, int material) const {
    if (material < 0 || !uses_set(materials_[static_cast<std::size_t>(material)], 1)) return 1;
    int set = 2;
    while (primitive["attributes"].contains(fmt::format("TEXCOORD_{}", set))) ++set;
    return set;
  }

  /// The attributes and morph targets of a primitive for other vertices, and their light.
  json attributes_for(const json& primitive, int material, const LitVertices& vertices, int set, bool turned,
                      AttributeWriter& writer) {
    json out = {{"attributes", primitive["attributes"]}};
    if (primitive.contains("targets")) out["targets"] = primitive["targets"];
    if (!vertices.unchanged() || writer.is_compressed()) {
      for (const auto& [name, accessor] : out["attributes"].items())
        accessor = writer.write(name, accessor, vertices.arranged(), turned && name == "NORMAL");
      if (out.contains("targets"))
        for (json& target : out["targets"])
          for (const auto& [name, accessor] : target.items())
            accessor = writer.write_target(accessor, vertices.arranged(), turned && name == "NORMAL");
    }
    json& attributes = out["attributes"];
    if (format_ == BakeFormat::vertex) {
      attributes["COLOR_0"] = add_colors(index_member(primitive["attributes"], "COLOR_0"), vertices, writer);
      return out;
    }
    std::vector<Vec2> uvs;
    for (const LitVertices::Entry& entry : vertices.arranged()) uvs.push_back(entry.uv);
    const int accessor = file_.add_pairs(uvs);
    attributes[fmt::format("TEXCOORD_{}", set)] = accessor;
    // Sets have no gaps (glTF 2.0, section 3.7.2.1).
    for (int s = 0; s < set; ++s)
      if (const std::string name = fmt::format("TEXCOORD_{}", s); !attributes.contains(name))
        attributes[name] = accessor;
    const bool opaque = material < 0 || !has_alpha(materials_[static_cast<std::size_t>(material)]);
    if (format_ == BakeFormat::unlit && opaque) drop_colors(out);
    return out;
  }

  /// Removes colours of vertices, which the light holds already.
  static void drop_colors(json& primitive) {
    std::vector<json*> lists{&primitive["attributes"]};
    if (primitive.contains("targets"))
      for (json& target : primitive["targets"]) lists.push_back(&target);
    for (json* list : lists)
      for (auto i = list->begin(); i != list->end();) i = i.key().starts_with("COLOR_") ? list->erase(i) : std::next(i);
  }

  /// The light of vertices as colours, times the file's colours. @param accessor of these; -1: none
  int add_colors(int accessor, const LitVertices& vertices, const AttributeWriter& writer) {
    const std::size_t components = accessor < 0 ? 3 : writer.components("COLOR_0", accessor);
    std::vector<float> own, out;
    if (accessor >= 0) own = writer.floats("COLOR_0", accessor, components);
    for (const LitVertices::Entry& entry : vertices.arranged()) {
      const Vec3 light = entry.layer >= 0 ? light_.color_at(entry.uv, entry.layer) : Vec3{0, 0, 0};
      for (std::size_t c = 0; c < components; ++c)
        out.push_back((c < 3 ? light[static_cast<int>(c)] : 1) *
                      (own.empty() ? 1 : own[entry.vertex * components + c]));
    }
    return file_.add_floats(out, components);
  }

  /// Materials of primitives without light, and of variants.
  std::set<int> materials_without_light() {
    std::set<std::pair<std::size_t, std::size_t>> lit;
    for (const auto& [key, primitives] : lit_primitives_)
      for (const LitPrimitive& p : primitives) lit.insert({p.mesh, p.primitive});
    std::set<int> out;
    for_each_primitive(file_.json, [&](std::size_t m, std::size_t p, const json& primitive) {
      if (!lit.contains({m, p})) out.insert(index_member(primitive, "material"));
      if (!primitive.contains("extensions") || !primitive["extensions"].contains(kVariants)) return;
      for (const json& mapping : primitive["extensions"][kVariants].value("mappings", json::array()))
        out.insert(index_member(mapping, "material"));
    });
    return out;
  }

  /// Adds the materials of lit primitives, in the places of those that nothing else uses.
  void add_materials() {
    std::set<int> kept = materials_without_light();
    kept.insert(-1);
    for (const auto& [key, primitives] : lit_primitives_) {
      const auto& [source, layer, one_sided, set] = key;
      json material = source >= 0 ? materials_[static_cast<std::size_t>(source)] : json::object();
      light_.light_material(material, layer, set);
      if (one_sided) material.erase("doubleSided");
      int index = source;
      if (kept.insert(source).second)
        file_.json["materials"][static_cast<std::size_t>(source)] = material;
      else
        index = file_.add("materials", material);
      for (const LitPrimitive& p : primitives)
        file_.json["meshes"][p.mesh]["primitives"][p.primitive]["material"] = index;
    }
  }

  /// Multiplies lamps and lights by the exposure. Divides lights with a position by the square of the scale, because
  /// the file keeps its units. Lights whose light is in a lightmap get intensity 0.
  void scale_lights() {
    for (std::size_t m = 0; m < materials_.size(); ++m) {
      json& material = file_.json["materials"][m];
      if (material == materials_[m]) light_.scale_glow(material);
    }
    if (!file_.json.contains("extensions") || !file_.json["extensions"].contains(kLights)) return;
    const bool is_baked = format_ == BakeFormat::lightmap && !notes_.indirect_only;
    const float gain = is_baked ? 0 : light_.gain(), scale = notes_.metres_per_unit;
    const GltfLightUnits& units = document_.light_units;
    for (json& light : file_.json["extensions"][kLights]["lights"]) {
      const bool has_position = light.value("type", "") != "directional";
      const float factor = has_position ? gain / units.intensity / (scale * scale) : gain / units.irradiance;
      light["intensity"] = light.value("intensity", 1.0f) * factor;
    }
  }

  /// Removes an extension that no object has any more from the lists of the file.
  void drop_unused(const std::string& name) {
    const std::vector<std::string> used = extensions_in(file_.json);
    if (std::find(used.begin(), used.end(), name) != used.end()) return;
    for (const char* list : {"extensionsUsed", "extensionsRequired"})
      if (file_.json.contains(list)) {
        erase_value(file_.json[list], name);
        if (file_.json[list].empty()) file_.json.erase(list);
      }
  }

  const GltfDocument& document_;
  const BakeLayout& layout_;
  BakeFormat format_;
  const BakeNotes& notes_;
  LightWriter light_;
  GlbFile file_;
  const json meshes_, materials_;        ///< of the source
  const GltfReferences references_;      ///< in the source
  std::vector<FaceInChart> faces_[2];    ///< fronts and backs, one a triangle
  std::set<int> shared_with_dark_;       ///< meshes that nodes without light show
  std::set<int> taken_;                  ///< meshes that show light themselves
  std::map<int, Instances> instancing_;  ///< of nodes that had them
  std::map<MaterialKey, std::vector<LitPrimitive>> lit_primitives_;
};

}  // namespace

std::string glb_of_gltf(const BakeLayout& layout, const EncodedLight& light, BakeFormat format,
                        const BakeNotes& notes) {
  json whole;
  const GltfDocument document = read_gltf_document(notes.gltf->path, {}, &whole);
  return GltfWriter(document, std::move(whole), layout, light, format, notes).write();
}

}  // namespace glowworm
