#include "gltf_writer/glb.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <set>

#include "core/error.h"
#include "core/json_text.h"

namespace glowworm {

namespace {

constexpr int kFloatType = 5126, kUnsignedType = 5125, kUnsignedShortType = 5123;
constexpr std::uint32_t kMostOfShort = 65535;  ///< not an index itself (glTF 2.0, section 3.7.2.1)
constexpr int kVertices = 34962, kIndices = 34963;

template <typename T>
std::string_view bytes_of(std::span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

void find_extensions(const nlohmann::json& json, std::set<std::string>& names) {
  for (const auto& [key, value] : json.items()) {
    if (key == "extras" || !value.is_structured()) continue;
    if (key == "extensions" && value.is_object())
      for (const auto& [name, extension] : value.items()) names.insert(name);
    find_extensions(value, names);
  }
}

void append_word(std::string& to, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  to.append(reinterpret_cast<const char*>(&word), sizeof word);
}

}  // namespace

int GlbFile::add(const char* list, nlohmann::json object) {
  json[list].push_back(std::move(object));
  return static_cast<int>(json[list].size()) - 1;
}

int GlbFile::add_view(std::string_view content, int target) {
  while (bytes.size() % 4 != 0) bytes.push_back('\0');
  nlohmann::json view = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", content.size()}};
  if (target != 0) view["target"] = target;
  bytes.append(content);
  return add("bufferViews", view);
}

int GlbFile::add_vectors(std::span<const Vec3> values, bool bounded) {
  nlohmann::json accessor = {{"bufferView", add_view(bytes_of(values), kVertices)},
                             {"componentType", kFloatType},
                             {"type", "VEC3"},
                             {"count", values.size()}};
  if (bounded) {
    constexpr float kFar = std::numeric_limits<float>::max();
    Vec3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
    for (const Vec3& v : values)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], v[axis]);
        high[axis] = std::max(high[axis], v[axis]);
      }
    accessor["min"] = {low.x, low.y, low.z};
    accessor["max"] = {high.x, high.y, high.z};
  }
  return add("accessors", accessor);
}

int GlbFile::add_floats(std::span<const float> values, std::size_t components) {
  constexpr const char* kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  return add("accessors", {{"bufferView", add_view(bytes_of(values), kVertices)},
                           {"componentType", kFloatType},
                           {"type", kTypes[components - 1]},
                           {"count", values.size() / components}});
}

int GlbFile::add_pairs(std::span<const Vec2> values) {
  static_assert(sizeof(Vec2) == 2 * sizeof(float));
  return add_floats({reinterpret_cast<const float*>(values.data()), 2 * values.size()}, 2);
}

int GlbFile::add_indices(std::span<const std::uint32_t> values) {
  const bool is_short = std::all_of(values.begin(), values.end(), [](std::uint32_t i) { return i < kMostOfShort; });
  std::vector<std::uint16_t> narrow;
  if (is_short)
    for (const std::uint32_t i : values) narrow.push_back(static_cast<std::uint16_t>(i));
  const std::string_view bytes_of_values =
      is_short ? bytes_of(std::span<const std::uint16_t>(narrow)) : bytes_of(values);
  return add("accessors", {{"bufferView", add_view(bytes_of_values, kIndices)},
                           {"componentType", is_short ? kUnsignedShortType : kUnsignedType},
                           {"type", "SCALAR"},
                           {"count", values.size()}});
}

int GlbFile::add_texture(const std::string& png, const std::string& name, bool repeats) {
  constexpr int kLinear = 9729, kLinearMipmaps = 9987, kClamp = 33071, kRepeat = 10497;
  const int wrap = repeats ? kRepeat : kClamp;
  const nlohmann::json sampler = {
      {"magFilter", kLinear}, {"minFilter", kLinearMipmaps}, {"wrapS", wrap}, {"wrapT", wrap}};
  nlohmann::json& samplers = json["samplers"];
  auto found = std::find(samplers.begin(), samplers.end(), sampler);
  const auto index = found - samplers.begin();
  if (found == samplers.end()) samplers.push_back(sampler);
  const int image = add("images", {{"bufferView", add_view(png, 0)}, {"mimeType", "image/png"}, {"name", name}});
  return add("textures", {{"sampler", index}, {"source", image}});
}

std::vector<std::string> extensions_in(const nlohmann::json& json) {
  std::set<std::string> names;
  find_extensions(json, names);
  return {names.begin(), names.end()};
}

std::string GlbFile::content() const {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  std::string binary = bytes;
  while (binary.size() % 4 != 0) binary.push_back('\0');
  nlohmann::json whole = json;
  if (!binary.empty()) whole["buffers"][0]["byteLength"] = binary.size();
  nlohmann::json& used = whole["extensionsUsed"];
  for (const std::string& name : extensions_in(whole))
    if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
  if (used.empty()) whole.erase("extensionsUsed");
  std::string text = json_text(whole);
  while (text.size() % 4 != 0) text.push_back(' ');
  const std::size_t size = kHeader + 2 * kChunkHeader + text.size() + binary.size();
  if (size > std::numeric_limits<std::uint32_t>::max())
    throw Error("a GLB file holds at most 4 GiB", "Give fewer --texels-per-metre.");
  std::string out = "glTF";
  append_word(out, 2);
  append_word(out, size);
  append_word(out, text.size());
  out += "JSON";
  out += text;
  append_word(out, binary.size());
  out.append("BIN\0", 4);
  return out + binary;
}

}  // namespace glowworm
