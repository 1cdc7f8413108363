// What a glTF file no longer needs after its materials and vertices are replaced.
#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "gltf_writer/glb.h"

namespace glowworm {

/// Lists of a glTF file, in the order in which their entries are removed: each before those that it refers to.
inline constexpr const char* kPrunedLists[] = {"textures", "samplers", "images", "accessors", "bufferViews"};

/// The entries of these lists that something refers to, by list.
using GltfReferences = std::map<std::string, std::set<std::size_t>>;

/// References by glTF 2.0 and by the extensions that prunable() knows.
GltfReferences references_in(nlohmann::json& file);

/// Whether all extensions of objects are known, so that no reference is missed. Extras are not read, but for those that
/// bakes write.
bool prunable(const nlohmann::json& file);

/// Removes entries of `before` that nothing refers to any more, and the bytes that only they have. Entries without
/// references before stay. Does nothing if the file is not prunable().
/// @param before references in the file as it was; its entries have the same indices now
void prune(const GltfReferences& before, GlbFile& file);

}  // namespace glowworm
