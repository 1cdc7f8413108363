// JSON as text.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace glowworm {

/// JSON as text. Names from files may be invalid UTF-8, which JSON does not allow: U+FFFD replaces such bytes.
/// @param indent spaces of a level; -1: all in one line
std::string json_text(const nlohmann::json& value, int indent = -1);

}  // namespace glowworm
