// Checks the JSON of a glTF file, so that other code can follow its references.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace glowworm {

/// The remedy of errors in damaged files.
inline constexpr const char* kDamagedGltf = "The file is damaged or invalid: export it again.";

/// Throws Error if brackets are nested too deeply for recursive parsers. Returns how many values and names of members
/// the text can have at most.
std::size_t check_json_depth(std::string_view text, const std::string& path);

/// Throws Error, which names file and object, if a part that this program reads has the wrong type, refers to something
/// that does not exist, or exceeds its container (glTF 2.0, sections 3.6 and 5).
void check_gltf_json(const nlohmann::json& root, const std::string& path);

/// A value that is an integer >= 0. Throws Error for any other. @param where its name for messages
std::size_t unsigned_value(const nlohmann::json& value, const std::string& where, const std::string& path);
/// A member that is an integer >= 0, or `otherwise` if it is absent. Throws Error for any other value.
/// @param where name of the object for messages: "bufferViews[3]"
std::size_t unsigned_member(const nlohmann::json& object, const char* key, std::size_t otherwise,
                            const std::string& where, const std::string& path);

}  // namespace glowworm
