#include "gltf_writer/gltf_prune.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace glowworm {

namespace {

using nlohmann::json;

constexpr const char* kListNames[] = {"textures", "samplers", "images", "accessors", "bufferViews"};
constexpr const char* kMeshoptNames[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

/// Calls `visit` with the member of an object, if there is one.
template <typename Json, typename Visit>
void with_member(Json& object, const char* key, const Visit& visit) {
  if (!object.is_object()) return;
  if (const auto found = object.find(key); found != object.end()) visit(*found);
}

/// Calls `visit` with an extension of an object, if it has it.
template <typename Json, typename Visit>
void with_extension(Json& object, const char* name, const Visit& visit) {
  with_member(object, "extensions", [&](Json& extensions) { with_member(extensions, name, visit); });
}

/// Calls `visit` with each entry of a list of an object.
template <typename Json, typename Visit>
void for_entries(Json& object, const char* key, const Visit& visit) {
  with_member(object, key, [&](Json& list) {
    if (list.is_structured())
      for (Json& entry : list) visit(entry);
  });
}

/// Visits the textures of a material: members of it and of its extensions whose names end in 'Texture'.
template <typename Json, typename Visit>
void for_textures(Json& object, const Visit& visit) {
  for (auto i = object.begin(); i != object.end(); ++i) {
    if (!i->is_object()) continue;
    const std::string_view key = i.key();
    if (key == "extras")
      with_member(*i, "lightmap", [&](Json& own) { with_member(own, "texture", visit); });
    else if (key.ends_with("Texture") || key == "MOZ_lightmap")
      with_member(*i, "index", visit);
    else
      for_textures(*i, visit);
  }
}

template <typename Json, typename Visit>
void for_accessors(Json& file, const Visit& visit) {
  for_entries(file, "meshes", [&](Json& mesh) {
    for_entries(mesh, "primitives", [&](Json& primitive) {
      with_member(primitive, "indices", visit);
      for_entries(primitive, "attributes", visit);
      for_entries(primitive, "targets", [&](Json& target) {
        for (Json& accessor : target) visit(accessor);
      });
    });
  });
  for_entries(file, "skins", [&](Json& skin) { with_member(skin, "inverseBindMatrices", visit); });
  for_entries(file, "animations", [&](Json& animation) {
    for_entries(animation, "samplers", [&](Json& sampler) {
      with_member(sampler, "input", visit);
      with_member(sampler, "output", visit);
    });
  });
  for_entries(file, "nodes", [&](Json& node) {
    with_extension(node, "EXT_mesh_gpu_instancing", [&](Json& own) { for_entries(own, "attributes", visit); });
  });
}

template <typename Json, typename Visit>
void for_views(Json& file, const Visit& visit) {
  for_entries(file, "accessors", [&](Json& accessor) {
    with_member(accessor, "bufferView", visit);
    with_member(accessor, "sparse", [&](Json& sparse) {
      for (const char* part : {"indices", "values"})
        with_member(sparse, part, [&](Json& elements) { with_member(elements, "bufferView", visit); });
    });
  });
  for_entries(file, "images", [&](Json& image) { with_member(image, "bufferView", visit); });
  for_entries(file, "meshes", [&](Json& mesh) {
    for_entries(mesh, "primitives", [&](Json& primitive) {
      with_extension(primitive, "KHR_draco_mesh_compression",
                     [&](Json& draco) { with_member(draco, "bufferView", visit); });
    });
  });
}

/// Calls `visit` with each reference to entries of a list.
template <typename Json, typename Visit>
void for_references(Json& file, GltfList list, const Visit& visit) {
  const auto indices_only = [&](Json& reference) {
    if (reference.is_number_unsigned() || reference.is_number_integer()) visit(reference);
  };
  switch (list) {
    case GltfList::textures:
      for_entries(file, "materials", [&](Json& material) {
        if (material.is_object()) for_textures(material, indices_only);
      });
      break;
    case GltfList::samplers:
      for_entries(file, "textures", [&](Json& texture) { with_member(texture, "sampler", indices_only); });
      break;
    case GltfList::images:
      for_entries(file, "textures", [&](Json& texture) {
        with_member(texture, "source", indices_only);
        for_entries(texture, "extensions", [&](Json& own) { with_member(own, "source", indices_only); });
      });
      break;
    case GltfList::accessors:
      for_accessors(file, indices_only);
      break;
    case GltfList::buffer_views:
      for_views(file, indices_only);
      break;
  }
}

/// Bytes [first, end) of the file's data.
struct ByteRange {
  std::size_t first = 0, end = 0;
};

/// Appends the bytes that a buffer view, or the extension that compresses it, has in the first buffer.
void add_ranges(const json& view, std::vector<ByteRange>& ranges) {
  const auto add = [&](const json& object) {
    if (object.value("buffer", std::size_t{1}) != 0) return;
    const std::size_t first = object.value("byteOffset", std::size_t{0});
    ranges.push_back({first, first + object.value("byteLength", std::size_t{0})});
  };
  add(view);
  for (const char* name : kMeshoptNames) with_extension(view, name, add);
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
  for_entries(file.json, "bufferViews", [&](json& view) {
    move(view);
    for (const char* name : kMeshoptNames) with_extension(view, name, move);
  });
}

/// Removes entries of a list and renumbers the others. Returns the removed ones.
std::vector<json> remove(const std::set<std::size_t>& entries, GltfList list, json& file) {
  const char* const name = kListNames[static_cast<std::size_t>(list)];
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
  for_references(file, list, [&](json& reference) {
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

GltfReferences references_in(const json& file) {
  GltfReferences out;
  for (std::size_t list = 0; list < kGltfLists; ++list)
    for_references(file, static_cast<GltfList>(list),
                   [&](const json& reference) { out[list].insert(reference.get<std::size_t>()); });
  return out;
}

void prune(const GltfReferences& before, GlbFile& file) {
  if (!prunable(file.json)) return;
  std::vector<ByteRange> dropped, kept;
  for (std::size_t list = 0; list < kGltfLists; ++list) {
    std::set<std::size_t> left = before[list];
    for_references(file.json, static_cast<GltfList>(list),
                   [&](const json& reference) { left.erase(reference.get<std::size_t>()); });
    for (const json& entry : remove(left, static_cast<GltfList>(list), file.json))
      if (static_cast<GltfList>(list) == GltfList::buffer_views) add_ranges(entry, dropped);
  }
  for_entries(file.json, "bufferViews", [&](const json& view) { add_ranges(view, kept); });
  cut(unused(std::move(dropped), std::move(kept), file.bytes.size()), file);
}

}  // namespace glowworm
