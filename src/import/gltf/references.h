// Where glTF files refer to entries of their lists.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace glowworm {

/// Members of a file whose values are indices into one of its lists. In `place`, [] is each entry of a list, and * each
/// member of an object.
struct GltfReference {
  std::string_view place, list;
};

/// References by glTF 2.0, and by extensions. Materials refer to textures in too many places to list.
inline constexpr GltfReference kGltfReferences[] = {
    {"scene", "scenes"},
    {"scenes[].nodes[]", "nodes"},
    {"nodes[].children[]", "nodes"},
    {"nodes[].mesh", "meshes"},
    {"nodes[].camera", "cameras"},
    {"nodes[].skin", "skins"},
    {"nodes[].extensions.EXT_mesh_gpu_instancing.attributes.*", "accessors"},
    {"meshes[].primitives[].material", "materials"},
    {"meshes[].primitives[].indices", "accessors"},
    {"meshes[].primitives[].attributes.*", "accessors"},
    {"meshes[].primitives[].targets[].*", "accessors"},
    {"meshes[].primitives[].extensions.KHR_draco_mesh_compression.bufferView", "bufferViews"},
    {"skins[].joints[]", "nodes"},
    {"skins[].inverseBindMatrices", "accessors"},
    {"animations[].samplers[].input", "accessors"},
    {"animations[].samplers[].output", "accessors"},
    {"animations[].channels[].target.node", "nodes"},
    {"textures[].sampler", "samplers"},
    {"textures[].source", "images"},
    {"textures[].extensions.*.source", "images"},
    {"images[].bufferView", "bufferViews"},
    {"accessors[].bufferView", "bufferViews"},
    {"accessors[].sparse.indices.bufferView", "bufferViews"},
    {"accessors[].sparse.values.bufferView", "bufferViews"},
    {"bufferViews[].buffer", "buffers"},
};

/// Visits all values at a place of GltfReference; their names are such as "meshes[3].primitives[0]".
/// @param where name of `at`; "": the file
/// @param wrong takes the names of values on the way that are not a "list" or an "object", and which it should be
void for_places(nlohmann::json& at, std::string_view place, const std::string& where,
                const std::function<void(nlohmann::json& value, const std::string& name)>& visit,
                const std::function<void(const std::string& name, const char* type)>& wrong);

}  // namespace glowworm
