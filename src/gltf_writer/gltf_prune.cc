#include "gltf_writer/gltf_prune.h"

#include <algorithm>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "import/gltf/references.h"

namespace glowworm {

namespace {

using nlohmann::json;

/// Buffer views, or the extensions that compress them, which refer to bytes.
constexpr const char* kByteRanges[] = {"", "extensions.EXT_meshopt_compression", "extensions.KHR_meshopt_compression"};

using Visit = std::function<void(json&)>;

/// Calls `visit` with all values at a place, as for_places() does.
void for_values(json& at, std::string_view place, const Visit& visit) {
  for_places(
      at, place, "", [&](json& value, const std::string&) { visit(value); }, [](const std::string&, const char*) {});
}

/// Visits the textures of a material: members of it and of its extensions whose names end in 'Texture'.
void for_textures(json& object, const Visit& visit) {
  for (auto i = object.begin(); i != object.end(); ++i) {
    if (!i->is_object()) continue;
    const std::string_view key = i.key();
    if (key == "extras")
      for_values(*i, "lightmap.texture", visit);
    else if (key.ends_with("Texture") || key == "MOZ_lightmap")
      for_values(*i, "index", visit);
    else
      for_textures(*i, visit);
  }
}

/// Calls `visit` with each reference to entries of a list.
void for_references(json& file, std::string_view list, const Visit& visit) {
  const auto indices_only = [&](json& reference) {
    if (reference.is_number_unsigned() || reference.is_number_integer()) visit(reference);
  };
  if (list == "textures")
    for_values(file, "materials[]", [&](json& material) {
      if (material.is_object()) for_textures(material, indices_only);
    });
  for (const GltfReference& reference : kGltfReferences)
    if (reference.list == list) for_values(file, reference.place, indices_only);
}

/// Bytes [first, end) of the file's data.
struct ByteRange {
  std::size_t first = 0, end = 0;
};

/// Appends the bytes that a buffer view, or the extension that compresses it, has in the first buffer.
void add_ranges(json& view, std::vector<ByteRange>& ranges) {
  const auto add = [&](const json& object) {
    if (object.value("buffer", std::size_t{1}) != 0) return;
    const std::size_t first = object.value("byteOffset", std::size_t{0});
    ranges.push_back({first, first + object.value("byteLength", std::size_t{0})});
  };
  for (const char* place : kByteRanges) for_values(view, place, add);
}

/// Sorts ranges and joins those that touch.
void join(std::vector<ByteRange>& ranges) {
  std::sort(ranges.begin(), ranges.end(), [](const ByteRange& a, const ByteRange& b) { return a.first < b.first; });
  std::vector<ByteRange> out;
  for (const ByteRange& range : ranges) {
    if (!out.empty() && range.first <= out.back().end)
      out.back().end = std::max(out.back().end, range.end);
    else
      out.push_back(range);
  }
  ranges = std::move(out);
}

/// The parts of `dropped` that no range of `kept` has, with padding, in whole words: what follows stays aligned.
std::vector<ByteRange> unused(std::vector<ByteRange> dropped, std::vector<ByteRange> kept, std::size_t size) {
  const auto up = [](std::size_t at) { return (at + 3) / 4 * 4; };
  for (ByteRange& range : dropped) range.end = std::min(up(range.end), size);
  join(dropped);
  join(kept);
  std::vector<ByteRange> out;
  const auto add = [&](std::size_t first, std::size_t end) {
    if (up(first) < end / 4 * 4) out.push_back({up(first), end / 4 * 4});
  };
  auto next = kept.begin();
  for (const ByteRange& range : dropped) {
    std::size_t at = range.first;
    while (next != kept.end() && next->end <= at) ++next;
    for (auto k = next; k != kept.end() && k->first < range.end; ++k) {
      if (k->first > at) add(at, k->first);
      at = std::max(at, k->end);
    }
    if (at < range.end) add(at, range.end);
  }
  return out;
}

/// Removes bytes, and moves the buffer views after them.
void cut(const std::vector<ByteRange>& ranges, GlbFile& file) {
  if (ranges.empty()) return;
  std::vector<std::size_t> removed{0};  // before and with each range
  std::string bytes;
  std::size_t at = 0;
  for (const ByteRange& range : ranges) {
    bytes.append(file.bytes, at, range.first - at);
    at = range.end;
    removed.push_back(removed.back() + range.end - range.first);
  }
  bytes.append(file.bytes, at);
  file.bytes = std::move(bytes);
  const auto move = [&](json& object) {
    if (object.value("buffer", std::size_t{1}) != 0 || !object.contains("byteOffset")) return;
    const auto offset = object["byteOffset"].get<std::size_t>();
    const auto before = std::upper_bound(ranges.begin(), ranges.end(), offset,
                                         [](std::size_t o, const ByteRange& range) { return o < range.end; });
    object["byteOffset"] = offset - removed[static_cast<std::size_t>(before - ranges.begin())];
  };
  for_values(file.json, "bufferViews[]", [&](json& view) {
    for (const char* place : kByteRanges) for_values(view, place, move);
  });
}

/// Removes entries of a list and renumbers the others. Returns the removed ones.
std::vector<json> remove(const std::set<std::size_t>& entries, const std::string& name, json& file) {
  std::vector<json> removed;
  if (entries.empty()) return removed;
  json left = json::array();
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < file[name].size(); ++i) {
    index.push_back(left.size());
    if (entries.contains(i))
      removed.push_back(std::move(file[name][i]));
    else
      left.push_back(std::move(file[name][i]));
  }
  if (left.empty())
    file.erase(name);
  else
    file[name] = std::move(left);
  for_references(file, name, [&](json& reference) {
    // Importers show what refers to no entry as missing.
    if (const auto at = reference.get<std::size_t>(); at < index.size()) reference = index[at];
  });
  return removed;
}

}  // namespace

bool prunable(const json& file) {
  constexpr std::string_view kKnown[] = {
      "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression", "EXT_mesh_gpu_instancing",
      "KHR_mesh_quantization",      "KHR_lights_punctual",     "KHR_texture_transform",   "KHR_texture_basisu",
      "EXT_texture_webp",           "EXT_texture_avif",        "MSFT_texture_dds",        "MOZ_lightmap"};
  const std::vector<std::string> names = extensions_in(file);
  return std::all_of(names.begin(), names.end(), [&](const std::string& name) {
    return name.starts_with("KHR_materials_") ||
           std::find(std::begin(kKnown), std::end(kKnown), name) != std::end(kKnown);
  });
}

GltfReferences references_in(json& file) {
  GltfReferences out;
  for (const char* list : kPrunedLists)
    for_references(file, list, [&](const json& reference) { out[list].insert(reference.get<std::size_t>()); });
  return out;
}

void prune(const GltfReferences& before, GlbFile& file) {
  if (!prunable(file.json)) return;
  std::vector<ByteRange> dropped, kept;
  for (const char* list : kPrunedLists) {
    std::set<std::size_t> left = before.contains(list) ? before.at(list) : std::set<std::size_t>();
    for_references(file.json, list, [&](const json& reference) { left.erase(reference.get<std::size_t>()); });
    for (json& entry : remove(left, list, file.json))
      if (list == std::string_view("bufferViews")) add_ranges(entry, dropped);
  }
  for_values(file.json, "bufferViews[]", [&](json& view) { add_ranges(view, kept); });
  cut(unused(std::move(dropped), std::move(kept), file.bytes.size()), file);
}

}  // namespace glowworm
