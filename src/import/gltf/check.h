// Checks of a glTF file's JSON: every reference in range, before anyone follows it.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace glowworm {

/// Throws Error where brackets are nested deeper than any glTF file needs, so that parsers that recurse are safe.
void check_json_depth(std::string_view text, const std::string& path);

/// Throws Error, naming file and object, where a part that this program reads has the wrong type, refers to something
/// that is not there, or reaches past the end of what holds it (glTF 2.0, sections 3.6 and 5).
void check_gltf_json(const nlohmann::json& root, const std::string& path);

/// A member that is an integer >= 0; `otherwise` where there is none. Throws Error where it is something else.
/// @param where names the object in messages: "bufferViews[3]"
std::size_t unsigned_member(const nlohmann::json& object, const char* key, std::size_t otherwise,
                            const std::string& where, const std::string& path);

}  // namespace glowworm
