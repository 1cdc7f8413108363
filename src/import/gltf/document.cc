#include "import/gltf/document.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "core/input_file.h"
#include "import/gltf/animation.h"
#include "import/gltf/check.h"
#include "import/gltf/compression.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr const char* kTruncatedRemedy = "The file is incomplete: copy or export it again.";
constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
/// Bytes for each value or name in JSON: in the trees of this program and of tinygltf, and in tinygltf's model.
constexpr std::size_t kTreeBytes = 100, kModelBytes = 160;

std::uint32_t little_endian_u32(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] | bytes[at + 1] << 8 | bytes[at + 2] << 16 | static_cast<std::uint32_t>(bytes[at + 3]) << 24;
}

/// The two chunks of a GLB file (glTF 2.0, section 4).
struct Chunks {
  std::span<const std::uint8_t> json, binary;
};

Chunks split_glb(std::span<const std::uint8_t> file, const std::string& path) {
  if (file.size() < 12) throw Error({path}, "ends within the GLB header", kTruncatedRemedy);
  const std::uint32_t version = little_endian_u32(file, 4), length = little_endian_u32(file, 8);
  if (version != 2) throw Error({path}, fmt::format("is GLB version {}, not 2", version), "Export it as glTF 2.0.");
  if (length > file.size()) {
    throw Error({path}, fmt::format("is truncated: the GLB header says {} bytes, the file has {}", length, file.size()),
                kTruncatedRemedy);
  }
  Chunks chunks;
  std::size_t at = 12;
  while (at + 8 <= length) {
    const std::size_t size = little_endian_u32(file, at);
    const std::uint32_t type = little_endian_u32(file, at + 4);
    if (size > length - at - 8) {
      throw Error(
          {path},
          fmt::format("is truncated: the chunk at byte {} says {} bytes, {} are left", at, size, length - at - 8),
          kTruncatedRemedy);
    }
    const std::span<const std::uint8_t> body = file.subspan(at + 8, size);
    if (type == kJsonChunk && chunks.json.empty()) chunks.json = body;
    if (type == kBinaryChunk && chunks.binary.empty()) chunks.binary = body;
    at += 8 + size;
  }
  if (chunks.json.empty()) throw Error({path}, "has no JSON chunk", kTruncatedRemedy);
  return chunks;
}

/// @param trees grows by the memory of all JSON that exists until the model is complete
json parse_json(std::span<const std::uint8_t> bytes, const GltfDocument& document, Reservation& trees) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t count = check_json_depth(text, document.path);
  trees.grow(text.size() + count * kTreeBytes);
  document.held->grow(count * kModelBytes);
  try {
    return json::parse(text.begin(), text.end());
  } catch (const json::exception& e) {
    throw Error({document.path}, std::string("is not valid JSON: ") + e.what(),
                "Is it a glTF file? If so, it is damaged: export it again.");
  }
}

bool is_meshopt_fallback(const json& buffer) {
  const auto extensions = buffer.find("extensions");
  if (extensions == buffer.end() || !extensions->is_object()) return false;
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    if (extensions->contains(name)) return true;
  }
  return false;
}

/// Reads one buffer. A placeholder for compressed data stays empty.
std::vector<std::uint8_t> read_buffer(const json& buffer, std::size_t index, const GltfDocument& document,
                                      std::span<const std::uint8_t> binary) {
  const std::string where = fmt::format("buffers[{}]", index);
  const std::size_t length = unsigned_member(buffer, "byteLength", 0, where, document.path);
  std::vector<std::uint8_t> bytes;
  std::string source = "the BIN chunk";
  if (!buffer.contains("uri")) {
    if (is_meshopt_fallback(buffer)) return {};
    if (index > 0 || binary.empty()) {
      throw Error({document.path}, where + " has neither a uri nor a BIN chunk", kTruncatedRemedy);
    }
    document.held->grow(binary.size());
    bytes.assign(binary.begin(), binary.end());
  } else {
    if (!buffer["uri"].is_string()) throw Error({document.path}, where + ".uri is not text", "Export the file again.");
    const std::string& uri = buffer["uri"].get_ref<const std::string&>();
    if (uri.starts_with("data:")) {
      source = "its data URI";
      document.held->grow(uri.size());
      bytes = decode_data_uri(uri);
    } else {
      source = "'" + decode_uri(uri) + "'";
      const std::filesystem::path file = std::filesystem::path(document.folder) / decode_uri(uri);
      std::error_code error;
      if (!std::filesystem::is_regular_file(file, error)) {
        throw Error({document.path}, fmt::format("{}: no such file {}", where, source),
                    "Put the .bin file beside the .gltf file, or export as .glb.");
      }
      bytes = read_input_bytes(file.string(), *document.held);
    }
  }
  if (bytes.size() < length) {
    throw Error({document.path},
                fmt::format("{} has {} bytes according to its byteLength, but {} holds {}", where, length, source,
                            bytes.size()),
                kTruncatedRemedy);
  }
  bytes.resize(length);
  return bytes;
}

/// Converts JSON by tinygltf, after removing everything that would make it open files.
std::unique_ptr<tinygltf::Model> map_json(const json& root, const std::string& path) {
  auto model = std::make_unique<tinygltf::Model>();
  std::string error, warning;
  bool good = false;
  try {
    const std::string text = root.dump();
    good = tinygltf::TinyGLTF().LoadASCIIFromString(model.get(), &error, &warning, text.data(),
                                                    static_cast<unsigned>(text.size()), "");
  } catch (const std::exception& e) {
    error = e.what();
  }
  if (!good) {
    while (!error.empty() && (error.back() == '\n' || error.back() == ' ')) error.pop_back();
    throw Error({path}, "is not a valid glTF file: " + error, "Export it again.");
  }
  return model;
}

/// Throws Error if the file cannot be shown without an extension that is not supported (glTF 2.0, section 3.12).
void check_required_extensions(const json& root, const std::string& path) {
  const auto required = root.find("extensionsRequired");
  if (required == root.end() || !required->is_array()) return;
  for (const json& name : *required) {
    if (!name.is_string() || is_supported_extension(name.get_ref<const std::string&>())) continue;
    throw Error({path},
                fmt::format("requires the extension {}, which is not supported", name.get_ref<const std::string&>()),
                "Export it without this extension.");
  }
}

void take_images(json& root, GltfDocument& document) {
  const auto images = root.find("images");
  if (images == root.end()) return;
  for (const json& source : *images) {
    GltfImage image;
    if (const auto uri = source.find("uri"); uri != source.end() && uri->is_string())
      image.uri = uri->get<std::string>();
    if (source.contains("bufferView")) image.buffer_view = source["bufferView"].get<int>();
    document.images.push_back(std::move(image));
  }
  root.erase("images");
}

void take_pointers(const json& root, GltfDocument& document) {
  static const json::json_pointer kProperty("/target/extensions/KHR_animation_pointer/pointer");
  const auto animations = root.find("animations");
  for (std::size_t i = 0; animations != root.end() && i < animations->size(); ++i) {
    const auto channels = (*animations)[i].find("channels");
    if (channels == (*animations)[i].end()) continue;
    for (const json& channel : *channels)
      if (channel.contains(kProperty) && channel[kProperty].is_string())
        document.pointers.push_back({i, channel["sampler"].get<std::size_t>(), channel[kProperty].get<std::string>()});
  }
}

/// Removes the index accessors of Draco primitives: they have no bytes, and tinygltf would reject them.
void drop_draco_indices(json& root) {
  if (!root.contains("meshes")) return;
  for (json& mesh : root["meshes"]) {
    for (json& primitive : mesh["primitives"]) {
      const auto extensions = primitive.find("extensions");
      if (extensions == primitive.end() || !extensions->is_object()) continue;
      if (extensions->contains("KHR_draco_mesh_compression")) primitive.erase("indices");
    }
  }
}

}  // namespace

GltfDocument::GltfDocument() = default;
GltfDocument::GltfDocument(GltfDocument&&) noexcept = default;
GltfDocument& GltfDocument::operator=(GltfDocument&&) noexcept = default;
GltfDocument::~GltfDocument() = default;

std::span<const std::uint8_t> GltfDocument::view(int index) const {
  const std::size_t i = static_cast<std::size_t>(index);
  if (!decoded_views.at(i).empty()) return decoded_views[i];
  const tinygltf::BufferView& view = model->bufferViews.at(i);
  const std::span<const std::uint8_t> buffer = buffers.at(static_cast<std::size_t>(view.buffer));
  if (buffer.size() < view.byteOffset + view.byteLength) {
    throw Error({path},
                fmt::format("bufferViews[{}] is in a buffer that is only a placeholder for compressed data", index),
                "Export the file again.");
  }
  return buffer.subspan(view.byteOffset, view.byteLength);
}

GltfDocument read_gltf_document(const std::string& path, const ImportOptions& options, json* whole) {
  Reservation held(*options.budget, "files", 0);
  return read_gltf_document(read_input_bytes(path, held), path, options, whole);
}

GltfDocument read_gltf_document(std::span<const std::uint8_t> file, const std::string& path,
                                const ImportOptions& options, json* whole) {
  GltfDocument document;
  document.budget = options.budget;
  document.held = std::make_unique<Reservation>(*options.budget, "buffers", 0);
  document.path = path;
  document.folder = std::filesystem::path(path).parent_path().string();
  if (file.empty()) throw Error({path}, "is empty", kTruncatedRemedy);
  const bool binary = file.size() >= 4 && std::memcmp(file.data(), "glTF", 4) == 0;
  const Chunks chunks = binary ? split_glb(file, path) : Chunks{file, {}};
  Reservation trees(*options.budget, "JSON", 0);
  json root = parse_json(chunks.json, document, trees);
  check_gltf_json(root, path);
  check_required_extensions(root, path);
  if (whole) *whole = root;
  document.light_units = light_units(root);
  if (const auto buffers = root.find("buffers"); buffers != root.end()) {
    for (std::size_t i = 0; i < buffers->size(); ++i) {
      document.buffers.push_back(read_buffer((*buffers)[i], i, document, chunks.binary));
    }
    root.erase("buffers");
  }
  take_images(root, document);
  take_pointers(root, document);
  drop_draco_indices(root);
  document.model = map_json(root, path);
  decode_meshopt_views(document);
  if (animate_properties(document, options.moment.animation, options.moment.seconds, root))
    document.model = map_json(root, path);
  return document;
}

bool is_supported_extension(std::string_view name) {
  static constexpr std::string_view kSupported[] = {"EXT_mesh_gpu_instancing",
                                                    "EXT_meshopt_compression",
                                                    "EXT_texture_webp",
                                                    "KHR_animation_pointer",
                                                    "KHR_draco_mesh_compression",
                                                    "KHR_lights_punctual",
                                                    "KHR_materials_anisotropy",
                                                    "KHR_materials_clearcoat",
                                                    "KHR_materials_diffuse_transmission",
                                                    "KHR_materials_dispersion",
                                                    "KHR_materials_emissive_strength",
                                                    "KHR_materials_ior",
                                                    "KHR_materials_iridescence",
                                                    "KHR_materials_pbrSpecularGlossiness",
                                                    "KHR_materials_scatter",
                                                    "KHR_materials_sheen",
                                                    "KHR_materials_specular",
                                                    "KHR_materials_transmission",
                                                    "KHR_materials_unlit",
                                                    "KHR_materials_variants",
                                                    "KHR_materials_volume",
                                                    "KHR_materials_volume_scatter",
                                                    "KHR_mesh_quantization",
                                                    "KHR_meshopt_compression",
                                                    "KHR_node_visibility",
                                                    "KHR_texture_transform"};
  return std::find(std::begin(kSupported), std::end(kSupported), name) != std::end(kSupported);
}

std::string decode_uri(const std::string& uri) {
  const auto digit = [](char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
  };
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      out.push_back(static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2])));
      i += 2;
    } else {
      out.push_back(uri[i]);
    }
  }
  return out;
}

std::vector<std::uint8_t> decode_data_uri(const std::string& uri) {
  static constexpr std::string_view kMark = ";base64,";
  const std::size_t mark = uri.find(kMark);
  if (!uri.starts_with("data:") || mark == std::string::npos) return {};
  // tinygltf knows only a few media types; the use of the data determines its type.
  const std::string plain = "data:application/octet-stream;base64," + uri.substr(mark + kMark.size());
  std::vector<std::uint8_t> bytes;
  std::string media_type;
  try {
    if (!tinygltf::DecodeDataURI(&bytes, media_type, plain, 0, false)) bytes.clear();
  } catch (const std::exception&) {
    bytes.clear();
  }
  return bytes;
}

}  // namespace glowworm
