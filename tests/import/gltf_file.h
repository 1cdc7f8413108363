// glTF files built by the tests.
#pragma once
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "test_files.h"

namespace glowworm {

/// A glTF file in the making: JSON, and one buffer.
struct GltfFile {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}};
  std::string bytes;

  template <typename T>
  int add_view(const std::vector<T>& values, int stride = 0) {
    while (bytes.size() % 4 != 0) bytes.push_back('\0');
    nlohmann::json view = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(T)}};
    if (stride > 0) view["byteStride"] = stride;
    append_bytes(bytes, values);
    return add("bufferViews", view);
  }
  int add(const char* list, const nlohmann::json& object) {
    json[list].push_back(object);
    return static_cast<int>(json[list].size()) - 1;
  }
  template <typename T>
  int add_accessor(const std::vector<T>& values, int component_type, const char* type, std::size_t count) {
    return add("accessors",
               {{"bufferView", add_view(values)}, {"componentType", component_type}, {"type", type}, {"count", count}});
  }
  /// A triangle (0,0,0) (1,0,0) (0,1,0) with texture coordinates (0,0) (1,0) (0,1) as a mesh.
  int add_triangle(const nlohmann::json& extra = nlohmann::json::object()) {
    const int positions = add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 5126, "VEC3", 3);
    const int uvs = add_accessor<float>({0, 0, 1, 0, 0, 1}, 5126, "VEC2", 3);
    nlohmann::json primitive = {{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uvs}}}};
    primitive.update(extra, true);
    return add("meshes", {{"primitives", {primitive}}});
  }
  /// A triangle of one material, in a node.
  void add_shown_triangle(const nlohmann::json& material) {
    add("nodes", {{"mesh", add_triangle({{"material", add("materials", material)}})}});
  }

  std::string text(const std::string& uri) const {
    nlohmann::json out = json;
    if (!bytes.empty() && !out.contains("buffers")) {
      out["buffers"] = nlohmann::json::array({{{"byteLength", bytes.size()}}});
    }
    if (out.contains("buffers") && !uri.empty()) out["buffers"][0]["uri"] = uri;
    return out.dump();
  }
  std::string glb() const {
    std::string text_chunk = text("");
    while (text_chunk.size() % 4 != 0) text_chunk.push_back(' ');
    std::string binary_chunk = bytes;
    while (binary_chunk.size() % 4 != 0) binary_chunk.push_back('\0');
    std::string out = "glTF";
    const auto size = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
    append_bytes<std::uint32_t>(
        out, {2, size(12 + 8 + text_chunk.size() + 8 + binary_chunk.size()), size(text_chunk.size()), 0x4E4F534A});
    out += text_chunk;
    append_bytes<std::uint32_t>(out, {size(binary_chunk.size()), 0x004E4942});
    return out + binary_chunk;
  }
};

class GltfTest : public FileTest {
 protected:
  std::string write_gltf(const GltfFile& file) const {
    write("a.bin", file.bytes);
    return write("a.gltf", file.text("a.bin"));
  }
  SceneDescription load(const GltfFile& file) const { return load_scene(write_gltf(file)); }
  std::string refusal(const GltfFile& file) const { return message_of(write_gltf(file)); }
  SceneDescription with_material(const nlohmann::json& material) const {
    GltfFile file;
    file.add_shown_triangle(material);
    return load(file);
  }
};

}  // namespace glowworm
