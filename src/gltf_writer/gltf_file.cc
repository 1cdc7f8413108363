#include "gltf_writer/gltf_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "core/input_file.h"
#include "import/texture_cache.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr const char* kMeshopt[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

/// Where a buffer of the source is in the file.
struct BufferPlace {
  std::size_t buffer = 0, offset = 0;
};

/// Joins all buffers to one. Placeholders for compressed data have no bytes, and follow it.
std::vector<BufferPlace> join_buffers(const GltfDocument& document, GlbFile& file) {
  constexpr std::size_t kAlignment = 16;
  std::vector<BufferPlace> places;
  const json source = file.json.value("buffers", json::array());
  json joined = json::array({json::object()});
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (document.buffers[i].empty()) {
      places.push_back({joined.size(), 0});
      joined.push_back(source[i]);
      continue;
    }
    if (file.bytes.empty()) joined[0] = source[i];
    while (file.bytes.size() % kAlignment != 0) file.bytes.push_back('\0');
    places.push_back({0, file.bytes.size()});
    file.bytes.append(document.buffers[i].begin(), document.buffers[i].end());
  }
  joined[0].erase("uri");
  file.json["buffers"] = joined;
  return places;
}

void move_view(json& view, const std::vector<BufferPlace>& places) {
  const BufferPlace& place = places.at(view.at("buffer").get<std::size_t>());
  view["buffer"] = place.buffer;
  if (place.offset > 0) view["byteOffset"] = view.value("byteOffset", std::size_t{0}) + place.offset;
}

std::string_view media_type(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG")) return "image/png";
  if (bytes.starts_with("\xff\xd8\xff")) return "image/jpeg";
  if (bytes.starts_with("RIFF") && bytes.substr(std::min<std::size_t>(8, bytes.size())).starts_with("WEBP"))
    return "image/webp";
  if (bytes.substr(std::min<std::size_t>(4, bytes.size())).starts_with("ftypavif")) return "image/avif";
  if (bytes.starts_with("DDS ")) return "image/vnd-ms.dds";
  return bytes.starts_with("\xabKTX 20\xbb") ? "image/ktx2" : "";
}

/// A path as a URI: percent-encoded (RFC 3986, section 2.1).
std::string encode_path(const std::string& path) {
  std::string out;
  for (const char c : path) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (is_letter || std::string_view("-._~/").find(c) != std::string_view::npos)
      out += c;
    else
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

/// Puts an image file into the new file where it may, and else names it from its folder.
void take_image(const GltfDocument& document, json& image, bool allow_outside, const std::string& folder,
                GlbFile& file) {
  const std::string uri = image.value("uri", "");
  if (uri.empty() || uri.starts_with("data:")) return;
  const std::string path = find_texture_file(document.folder, decode_uri(uri));
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return;
  Reservation held(*document.budget, "image files", 0);
  const bool may_copy = allow_outside || !is_outside(path, document.path);
  const std::string bytes = may_copy ? read_input_file(path, held) : "";
  if (const std::string_view type = media_type(bytes); !type.empty()) {
    image.erase("uri");
    image["mimeType"] = type;
    image["bufferView"] = file.add_view(bytes, 0);
    return;
  }
  const std::filesystem::path from_there = std::filesystem::relative(path, folder.empty() ? "." : folder, error);
  if (!error) image["uri"] = encode_path(from_there.generic_string());
}

}  // namespace

GlbFile glb_of_document(const GltfDocument& document, json whole, bool allow_outside, const std::string& folder) {
  GlbFile file;
  file.json = std::move(whole);
  const std::vector<BufferPlace> places = join_buffers(document, file);
  if (file.json.contains("bufferViews"))
    for (json& view : file.json["bufferViews"]) {
      move_view(view, places);
      if (!view.contains("extensions")) continue;
      for (const char* name : kMeshopt)
        if (view["extensions"].contains(name)) move_view(view["extensions"][name], places);
    }
  if (file.json.contains("images"))
    for (json& image : file.json["images"]) take_image(document, image, allow_outside, folder, file);
  return file;
}

}  // namespace glowworm
