#include "import/gltf/import.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/frame.h"
#include "core/input_file.h"
#include "core/parallel.h"
#include "import/gltf/accessor.h"
#include "import/gltf/animation.h"
#include "import/gltf/check.h"
#include "import/gltf/document.h"
#include "import/gltf/material.h"
#include "import/gltf/mesh.h"
#include "import/gltf/parts.h"
#include "import/gltf/pose.h"
#include "import/gltf/reader.h"
#include "import/gltf/value.h"
#include "import/ies/luminaire.h"
#include "import/instance_keeper.h"
#include "import/mesh_tools.h"
#include "import/notes.h"
#include "import/texture_cache.h"
#include "import/texture_nodes.h"

namespace glowworm {

namespace {

constexpr int kDeepestNode = 1000;

/// Whether all numbers are finite as floats.
bool is_finite(const Transform& t) {
  return glowworm::is_finite(t.x) && glowworm::is_finite(t.y) && glowworm::is_finite(t.z) &&
         glowworm::is_finite(t.translation);
}

Vec3 unit_or(Vec3 v, Vec3 otherwise) {
  const float l = length(v);
  return l > 0 && std::isfinite(l) ? v / l : otherwise;
}

/// Builds a scene description from a document.
class GltfBuilder {
 public:
  GltfBuilder(const GltfDocument& document, GltfMeshes& meshes, const ImportOptions& options, CoordinateOrigin& origin)
      : origin_(origin),
        document_(document),
        model_(*document.model),
        meshes_(meshes),
        triangles_(*options.budget, "triangles", 0),
        keeper_(description_.geometry, origin, triangles_),
        textures_(options, notes_),
        materials_(document, textures_, notes_, description_),
        moment_(options.moment),
        pose_(document, options.moment),
        motion_(options.motion),
        light_uvs_(options.light_uvs),
        parts_(options.gltf_parts) {}

  SceneDescription build() {
    description_.name = std::filesystem::path(document_.path).stem().string();
    // The last one is for primitives without a material.
    for (std::size_t i = 0; i <= model_.materials.size(); ++i) material_info_.push_back(materials_.add(i));
    description_.materials.back().name = "glTF default";
    // Skinned meshes need the transforms of all joints, so they follow after all nodes are placed.
    for (const int root : root_nodes()) place(root, TransformDouble{}, true, 0);
    check_room();
    for (const PlacedNode& node : placed_) add_node(node.index, node.visible);
    if (motion_ && !model_.animations.empty()) motion_->length = animation_seconds(document_, moment_.animation);
    if (motion_ && (!motion_->is_still || (motion_->slice_count() > 0 && !model_.animations.empty()))) add_motion();
    description_.geometry.number_instances();
    if (parts_) number_parts();
    note_extensions();
    // glTF viewers add lights unless the file has some. Emission lights a scene only if that is plausible, as in a room
    // with a glowing lamp.
    description_.emission_may_be_decoration = true;
    note_variants();
    if ((!motion_ || (motion_->is_still && motion_->slice_count() == 0)) && moment_.seconds == 0)
      notes_.add("animation: the first moment is shown; --at shows another", model_.animations.size());
    if (parts_) notes_.add("skin: its mesh gets the light of the file's pose", model_.skins.size());
    notes_.write_to(description_.notes);
    return std::move(description_);
  }

 private:
  struct PlacedNode {
    int index = 0;
    bool visible = true;
  };

  std::vector<int> root_nodes() {
    if (!model_.scenes.empty()) {
      notes_.add("scene besides the one shown, left out", model_.scenes.size() - 1);
      return model_.scenes[static_cast<std::size_t>(std::max(0, model_.defaultScene))].nodes;
    }
    std::vector<bool> is_child(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes) {
      for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
    }
    std::vector<int> roots;
    for (std::size_t i = 0; i < is_child.size(); ++i) {
      if (!is_child[i]) roots.push_back(static_cast<int>(i));
    }
    return roots;
  }

  /// @param visible whether the nodes above are (KHR_node_visibility)
  void place(int index, const TransformDouble& parent, bool visible, int depth) {
    if (depth > kDeepestNode || !visited_.insert(index).second) {
      throw Error({document_.path}, fmt::format("nodes[{}] is a child of two nodes, of itself, or too deep", index),
                  kDamagedGltf);
    }
    const TransformDouble to_world = parent * pose_.local(index);
    if (!is_finite(to_world.relative_to({0, 0, 0}))) {
      notes_.add("node whose place is beyond the range of numbers, left out");
      return;
    }
    pose_.place(index, to_world);
    const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(index)];
    if (const auto* visibility = find_extension(node.extensions, "KHR_node_visibility"))
      visible = visible && bool_member(*visibility, "visible", true);
    placed_.push_back({index, visible});
    for (const int child : node.children) {
      parent_[child] = index;
      place(child, to_world, visible, depth + 1);
    }
  }

  /// A node's transform to the world in another pose.
  TransformDouble to_world_in(const GltfPose& pose, int index) const {
    TransformDouble out = pose.local(index);
    for (auto above = parent_.find(index); above != parent_.end(); above = parent_.find(above->second))
      out = pose.local(above->second) * out;
    return out;
  }

  /// Whether what the node shows or lights is the same in another pose.
  bool is_same_in(const GltfPose& pose, int index) const {
    const auto same = [](const TransformDouble& a, const TransformDouble& b) {
      return a.x == b.x && a.y == b.y && a.z == b.z && a.translation == b.translation;
    };
    return same(to_world_in(pose, index), to_world_in(pose_, index)) && pose.weights(index) == pose_.weights(index);
  }

  /// Adds a camera for each moment of the motion, and finds out whether anything else moves.
  void add_motion() {
    std::set<int> shown;  // nodes that meshes and lights depend on
    const tinygltf::Node* camera = nullptr;
    int camera_index = -1;
    for (const PlacedNode& placed : placed_) {
      const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(placed.index)];
      if (node.mesh >= 0 || find_extension(node.extensions, "KHR_lights_punctual")) shown.insert(placed.index);
      if (node.skin >= 0)
        for (const int joint : model_.skins[static_cast<std::size_t>(node.skin)].joints) shown.insert(joint);
      if (node.camera < 0 || camera) continue;
      const std::string& own = model_.cameras[static_cast<std::size_t>(node.camera)].name;
      if (!motion_->camera.empty() && motion_->camera != (node.name.empty() ? own : node.name)) continue;
      camera = &node;
      camera_index = placed.index;
    }
    motion_->anything_else_moves = moves_properties(document_, moment_.animation);
    motion_->cover_length();
    for (const FrameMoment moment : motion_->moments()) {
      if (!camera && motion_->anything_else_moves) break;
      const GltfPose pose(document_, {moment_.animation, motion_->seconds(moment)});
      motion_->anything_else_moves |=
          !std::all_of(shown.begin(), shown.end(), [&](int node) { return is_same_in(pose, node); });
      if (!camera) continue;
      const std::size_t before = description_.cameras.size();
      add_camera(*camera, pose.lens(camera->camera), to_world_in(pose, camera_index).relative_to(origin_.origin()));
      if (description_.cameras.size() > before) description_.cameras.back().name = moment.camera();
    }
  }

  void add_node(int index, bool visible) {
    const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(index)];
    const TransformDouble& to_world = pose_.to_world(index);
    const Transform relative = to_world.relative_to(origin_.origin());
    if (node.camera >= 0) add_camera(node, pose_.lens(node.camera), relative);
    if (!visible) return notes_.add("hidden mesh, left out (KHR_node_visibility)", node.mesh >= 0);
    if (node.mesh >= 0) add_instances(index, to_world);
    if (const auto* light = find_extension(node.extensions, "KHR_lights_punctual")) {
      add_light(node, static_cast<int>(number_member(*light, "light", -1)), relative);
    }
  }

  /// Adds the mesh of a node, once or at each place of EXT_mesh_gpu_instancing.
  void add_instances(int index, const TransformDouble& to_world) {
    const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(index)];
    const GltfDeformation deformation = pose_.deformation(index, origin_.origin());
    const auto* instancing = find_extension(node.extensions, "EXT_mesh_gpu_instancing");
    if (!instancing || !instancing->Has("attributes")) {
      add_mesh(index, -1, to_world, deformation);
      return;
    }
    // Without triangles, no place is shown.
    if (bytes_of(node.mesh, 1) == 0) return;
    const tinygltf::Value& attributes = instancing->Get("attributes");
    Reservation places(*document_.budget, "places of instances", 0);
    const auto read = [&](const char* name, int components) {
      places.grow(count_of(attributes, name) * static_cast<std::size_t>(components) * sizeof(float));
      const int accessor = accessor_of(attributes, name);
      return accessor < 0 ? std::vector<float>() : read_floats(document_, accessor, components);
    };
    const std::vector<float> t = read("TRANSLATION", 3), r = read("ROTATION", 4), s = read("SCALE", 3);
    const std::size_t count = std::max({t.size() / 3, r.size() / 4, s.size() / 3});
    for (std::size_t i = 0; i < count; ++i) {
      double q[4] = {0, 0, 0, 1};
      if (4 * i + 3 < r.size()) std::copy_n(r.begin() + static_cast<std::ptrdiff_t>(4 * i), 4, q);
      const bool scaled = 3 * i + 2 < s.size();
      TransformDouble instance =
          gltf_rotation_and_scale(q, scaled ? Vec3d{s[3 * i], s[3 * i + 1], s[3 * i + 2]} : Vec3d{1, 1, 1});
      if (3 * i + 2 < t.size()) instance.translation = {t[3 * i], t[3 * i + 1], t[3 * i + 2]};
      add_mesh(index, static_cast<int>(i), to_world * instance, deformation);
    }
  }

  /// A primitive of a mesh, read on first use.
  const Geometry& primitive(int mesh, std::size_t index, const GltfMaterialInfo& info, const std::string& where) {
    return meshes_.primitive(mesh, index, [&] {
      const tinygltf::Primitive& source = model_.meshes[static_cast<std::size_t>(mesh)].primitives[index];
      GltfUvSets uv_sets = info.uv_sets;
      if (light_uvs_ && uv_sets.second < 0) uv_sets.second = 1;
      return read_gltf_primitive(document_, source, uv_sets, where, notes_);
    });
  }

  /// Calls `use` for each primitive of a mesh, with its material and its name for messages.
  template <typename Use>
  void for_each_primitive(int index, const Use& use) {
    const tinygltf::Mesh& mesh = model_.meshes[static_cast<std::size_t>(index)];
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      const std::string where = fmt::format("meshes[{}].primitives[{}]", index, i);
      const int own = mesh.primitives[i].material;
      const auto material = own >= 0 ? static_cast<std::size_t>(own) : model_.materials.size();
      use(primitive(index, i, material_info_.at(material), where), mesh.primitives[i], material, where);
    }
  }

  /// The accessor of an attribute of EXT_mesh_gpu_instancing, or -1.
  int accessor_of(const tinygltf::Value& attributes, const char* name) const {
    const int accessor = static_cast<int>(number_member(attributes, name, -1));
    return accessor < static_cast<int>(model_.accessors.size()) ? std::max(accessor, -1) : -1;
  }
  std::size_t count_of(const tinygltf::Value& attributes, const char* name) const {
    const int accessor = accessor_of(attributes, name);
    return accessor < 0 ? 0 : model_.accessors[static_cast<std::size_t>(accessor)].count;
  }

  /// Bytes of the triangles of a mesh in the scene, at some places.
  double bytes_of(int index, double places) {
    double bytes = 0;
    for_each_primitive(index,
                       [&](const Geometry& mesh, const tinygltf::Primitive&, std::size_t material, const std::string&) {
                         if (mesh.triangles.empty()) return;
                         const bool emits = material_info_.at(material).emission != kNone;
                         bytes += emits ? places * static_cast<double>(scene_bytes(mesh)) : shared_bytes(mesh, places);
                       });
    return bytes;
  }

  /// Throws MemoryError if all instances of EXT_mesh_gpu_instancing do not fit into the budget, before the first is
  /// made: a small file can name billions.
  void check_room() {
    double bytes = 0;
    for (const PlacedNode& placed : placed_) {
      const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(placed.index)];
      const auto* instancing = find_extension(node.extensions, "EXT_mesh_gpu_instancing");
      if (!placed.visible || node.mesh < 0 || !instancing || !instancing->Has("attributes")) continue;
      std::size_t count = 0;
      for (const char* name : {"TRANSLATION", "ROTATION", "SCALE"})
        count = std::max(count, count_of(instancing->Get("attributes"), name));
      bytes += bytes_of(node.mesh, static_cast<double>(count));
    }
    const Reservation room(*document_.budget, "triangles of instances",
                           static_cast<std::uint64_t>(std::min(bytes, 1e18)));
  }

  /// Adds the mesh of a node. @param number of the instance, or -1
  void add_mesh(int node, int number, const TransformDouble& to_world, const GltfDeformation& deformation) {
    check_cancelled();
    const int index = model_.nodes[static_cast<std::size_t>(node)].mesh;
    const std::string& own_name = model_.meshes[static_cast<std::size_t>(index)].name;
    const std::string name = own_name.empty() ? fmt::format("mesh {}", index) : own_name;
    const bool is_kept =
        deformation.weights.empty() && deformation.joints.empty() && keep_instance(node, number, to_world, name);
    if (!is_kept) description_.geometry.begin_object(name);
    for_each_primitive(index, [&](const Geometry& mesh, const tinygltf::Primitive& source, std::size_t material,
                                  const std::string& where) {
      if (mesh.triangles.empty()) return;
      const GltfMaterialInfo info = mesh.colors.empty() ? material_info_.at(material) : tinted(material);
      if (is_kept && info.emission == kNone) return;
      if (is_kept) description_.geometry.begin_object(name);
      triangles_.grow(scene_bytes(mesh));
      Geometry instance = mesh;
      deform_gltf_primitive(document_, source, deformation, where, instance);
      if (deformation.joints.empty()) {
        place_mesh(instance, to_world, origin_);
      } else {
        for (const Vec3 p : instance.positions) origin_.cover(Vec3d(p) + Vec3d(origin_.origin()));
      }
      const std::size_t first = description_.geometry.triangles.size();
      append_counted(description_.geometry, instance, document_.path + ": " + where, info.index, info.emission, notes_);
      if (parts_) add_part(node, number, source, mesh, instance, first);
    });
  }

  /// The primitives of a mesh that do not emit light, as one mesh.
  Geometry merged_primitives(int index, std::vector<GltfPart>& parts) {
    Geometry out;
    for_each_primitive(index, [&](const Geometry& mesh, const tinygltf::Primitive& source, std::size_t material,
                                  const std::string& where) {
      if (mesh.triangles.empty()) return;
      const GltfMaterialInfo info = mesh.colors.empty() ? material_info_.at(material) : tinted(material);
      if (info.emission != kNone) return;
      const std::size_t first = out.triangles.size();
      append_counted(out, mesh, document_.path + ": " + where, info.index, kNone, notes_);
      parts.push_back(part_of(index, source, mesh, first, out.triangles.size() - first));
    });
    return out;
  }

  /// Whether the mesh of a node is an instance now. Its primitives that emit light are not part of it.
  bool keep_instance(int node, int number, const TransformDouble& to_world, const std::string& name) {
    const int index = model_.nodes[static_cast<std::size_t>(node)].mesh;
    std::vector<GltfPart>& parts = shared_parts_[index];
    const std::uint32_t instance = keeper_.keep(&model_.meshes[static_cast<std::size_t>(index)], to_world, name, [&] {
      return SharedMesh{merged_primitives(index, parts), {}};
    });
    if (instance == kNone) return false;
    if (!parts_) return true;
    for (GltfPart part : parts) {
      part.node = node;
      part.instance = number;
      part.mirrored = to_world.determinant() < 0;
      parts_->parts.push_back(std::move(part));
      instance_parts_.emplace_back(parts_->parts.size() - 1, instance);
    }
    return true;
  }

  /// Numbers the triangles of parts that are instances, which so far counted from the first of the instance.
  void number_parts() {
    for (const auto& [part, instance] : instance_parts_)
      parts_->parts[part].first_triangle += description_.geometry.instances[instance].first;
    std::stable_sort(parts_->parts.begin(), parts_->parts.end(),
                     [](const GltfPart& a, const GltfPart& b) { return a.first_triangle < b.first_triangle; });
  }

  /// A primitive that became some triangles. @param placed its mesh where that is
  GltfPart part_of(int mesh, const tinygltf::Primitive& source, const Geometry& placed, std::size_t first,
                   std::size_t count) const {
    GltfPart part;
    part.mesh = mesh;
    const auto& primitives = model_.meshes[static_cast<std::size_t>(mesh)].primitives;
    part.primitive = static_cast<std::size_t>(&source - primitives.data());
    part.first_triangle = static_cast<std::uint32_t>(first);
    part.count = static_cast<std::uint32_t>(count);
    for (std::uint32_t t = 0; count < placed.triangles.size() && t < placed.triangles.size(); ++t) {
      const float area = placed.doubled_area(t);
      if (!(area > 0 && std::isfinite(area))) part.dropped.push_back(t);
    }
    return part;
  }

  /// Records the origin of the triangles from `first` on. @param mesh before it was placed
  void add_part(int node, int number, const tinygltf::Primitive& source, const Geometry& mesh, const Geometry& instance,
                std::size_t first) {
    GltfPart part = part_of(model_.nodes[static_cast<std::size_t>(node)].mesh, source, instance, first,
                            description_.geometry.triangles.size() - first);
    part.node = node;
    part.instance = number;
    part.mirrored = instance.triangles != mesh.triangles;
    parts_->parts.push_back(std::move(part));
  }

  /// A material whose colour is multiplied by vertex colours.
  const GltfMaterialInfo& tinted(std::size_t material) {
    const auto found = tinted_.find(material);
    if (found != tinted_.end()) return found->second;
    return tinted_[material] = materials_.add(material, true);
  }

  void add_camera(const tinygltf::Node& node, const GltfLens& lens, const Transform& to_world) {
    const tinygltf::Camera& source = model_.cameras[static_cast<std::size_t>(node.camera)];
    Camera camera;
    camera.name = !node.name.empty() ? node.name : source.name;
    // glTF's cameras look along -z and are not scaled.
    camera.to_world = {unit_or(to_world.x, {1, 0, 0}), unit_or(to_world.y, {0, 1, 0}), -unit_or(to_world.z, {0, 0, 1}),
                       to_world.translation};
    double extent = 0;  // half the picture's height, then half its shorter side
    if (source.type == "orthographic") {
      camera.kind = CameraKind::orthographic;
      extent = std::min(std::abs(lens.xmag), std::abs(lens.ymag));
      camera.aspect = static_cast<float>(std::abs(lens.xmag / lens.ymag));
    } else {
      extent = std::tan(std::clamp(lens.yfov, 0.0, 3.1) / 2);
      if (lens.aspect_ratio > 0 && lens.aspect_ratio < 1) extent *= lens.aspect_ratio;
      camera.aspect = static_cast<float>(lens.aspect_ratio);
    }
    camera.half_extent = static_cast<float>(extent);
    if (!(camera.half_extent > 0) || !std::isfinite(camera.half_extent)) {
      notes_.add("camera '" + camera.name + "' has no field of view, left out");
      return;
    }
    description_.cameras.push_back(std::move(camera));
  }

  void add_light(const tinygltf::Node& node, int index, const Transform& to_world) {
    if (index < 0 || index >= static_cast<int>(model_.lights.size())) {
      throw Error({document_.path},
                  fmt::format("node '{}' names light {}, but there are {}", node.name, index, model_.lights.size()),
                  kDamagedGltf);
    }
    const tinygltf::Light& source = model_.lights[static_cast<std::size_t>(index)];
    const std::string file = photometric_file(node, source);
    Light light;
    if (!file.empty()) light = read_luminaire(file);
    light.name = !node.name.empty() ? node.name : source.name;
    const Vec3 tint = narrow(vector_of(source.color, {1, 1, 1}));
    const RGB color(tint.x, tint.y, tint.z);
    const GltfLightUnits& units = document_.light_units;
    const float unit = source.type == "directional" ? units.irradiance : units.intensity;
    if (file.empty()) light.intensity = RGB(static_cast<float>(source.intensity) / unit);
    light.intensity *= source.intensity == 0 ? RGB(0.0f) : color;
    light.position = to_world.translation;
    light.direction = -unit_or(to_world.z, {0, 0, 1});
    if (!file.empty()) {
      const Vec3 across = to_world.x - light.direction * dot(to_world.x, light.direction);
      light.right = unit_or(across, Frame::from_normal(light.direction).s);
      if (to_world.determinant() < 0) mirror_luminaire(light);
    } else if (source.type == "spot") {
      light.kind = LightKind::spot;
      light.cos_inner = static_cast<float>(std::cos(source.spot.innerConeAngle));
      light.cos_outer = std::min(static_cast<float>(std::cos(source.spot.outerConeAngle)), light.cos_inner);
      light.falloff = SpotFalloff::quadratic;
    } else if (source.type == "directional") {
      light.kind = LightKind::directional;
    } else if (source.type != "point") {
      notes_.add("light of type '" + source.type + "' is not supported, left out");
      return;
    }
    if (!glowworm::is_finite(light.intensity) || light.intensity.r < 0 || light.intensity.g < 0 ||
        light.intensity.b < 0) {
      notes_.add("light '" + light.name + "' has no valid intensity, left out");
      return;
    }
    if (source.range > 0) notes_.add("range of a light, not used: light falls off by the square of the distance");
    description_.lights.push_back(std::move(light));
  }

  /// The photometric file that gives a light its intensities, unless its own is 0, or nothing: "luminaire" in the
  /// extras of the light or its node, or the name of either if that is a file beside the scene.
  std::string photometric_file(const tinygltf::Node& node, const tinygltf::Light& light) {
    const std::filesystem::path folder = document_.folder;
    for (const tinygltf::Value* extras : {&light.extras, &node.extras})
      if (extras->IsObject() && extras->Has("luminaire") && extras->Get("luminaire").IsString())
        return (folder / extras->Get("luminaire").Get<std::string>()).string();
    for (const std::string& name : {node.name, light.name}) {
      if (!is_photometric_file(name)) continue;
      const std::string file = (folder / name).string();
      if (std::filesystem::is_regular_file(file)) return file;
      notes_.add("light '" + name + "' is named like a photometric file, but there is none beside the scene");
    }
    return {};
  }

  /// Adds a note on the variants of KHR_materials_variants. The file's default variant is shown.
  void note_variants() {
    const auto* variants = find_extension(model_.extensions, "KHR_materials_variants");
    if (!variants || !variants->Has("variants") || !variants->Get("variants").IsArray()) return;
    std::string names;
    for (int i = 0; i < static_cast<int>(variants->Get("variants").ArrayLen()); ++i) {
      const tinygltf::Value& variant = variants->Get("variants").Get(i);
      const bool named = variant.IsObject() && variant.Has("name") && variant.Get("name").IsString();
      names += (names.empty() ? "\"" : ", \"") + (named ? variant.Get("name").Get<std::string>() : "") + "\"";
    }
    notes_.add("variants of materials (" + names + "): the materials that the file names first are shown");
  }

  void note_extensions() {
    for (const std::string& name : model_.extensionsUsed) {
      if (!is_supported_extension(name)) notes_.add("extension " + name + " is not supported, left out");
    }
  }

  CoordinateOrigin& origin_;
  const GltfDocument& document_;
  const tinygltf::Model& model_;
  NoteCounter notes_;
  SceneDescription description_;
  GltfMeshes& meshes_;
  Reservation triangles_;
  InstanceKeeper keeper_;
  TextureCache textures_;
  GltfMaterials materials_;
  std::vector<GltfMaterialInfo> material_info_;  ///< for each material of the file, then the default material
  const Moment moment_;
  GltfPose pose_;
  const std::shared_ptr<SceneMotion> motion_;
  std::map<int, int> parent_;  // of each node below another
  bool light_uvs_;
  std::shared_ptr<GltfParts> parts_;                                   ///< null: not wanted
  std::vector<PlacedNode> placed_;                                     ///< in the order of the file's tree
  std::map<int, std::vector<GltfPart>> shared_parts_;                  // of each mesh that is instanced
  std::vector<std::pair<std::size_t, std::uint32_t>> instance_parts_;  ///< numbers of a part and its instance
  std::map<std::size_t, GltfMaterialInfo> tinted_;
  std::set<int> visited_;
};

}  // namespace

SceneDescription load_gltf(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin) {
  const InputRecord record;
  const std::shared_ptr<GltfReader> reader = options.gltf ? options.gltf : gltf_reader();
  const GltfDocument& document = reader->document(path, options);
  const std::set<std::string> data_files = record.names();
  SceneDescription description = build_gltf_scene(document, options, origin, &reader->meshes());
  if (options.gltf_parts) options.gltf_parts->data_files = data_files;
  return description;
}

SceneDescription build_gltf_scene(const GltfDocument& document, const ImportOptions& options, CoordinateOrigin& origin,
                                  GltfMeshes* meshes) {
  std::optional<GltfMeshes> own;
  if (!meshes) meshes = &own.emplace(options.budget);
  if (options.gltf_parts) *options.gltf_parts = {document.path, {}, {}};
  SceneDescription description = GltfBuilder(document, *meshes, options, origin).build();
  if (description.geometry.triangle_count() == 0) {
    throw Error({document.path}, "has no triangles that can be shown", "Export the meshes with it.");
  }
  return description;
}

}  // namespace glowworm
