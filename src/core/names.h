// Names to choose from, on the command line and elsewhere.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace glowworm {

/// "Did you mean 'NAME'? " with the name that is near to the text, or "" where none is.
std::string did_you_mean(const std::string& text, const std::vector<std::string>& names);

/// Index of `text` among `names`. Throws Error that names `what` ("--engine"), lists the names, and suggests the names
/// closest to the text.
std::size_t name_index(const std::string& what, const std::string& text, const std::vector<std::string>& names);

/// Makes names unique: "lamp 1", "lamp 2" where "lamp" occurs twice.
void number_repeated(std::vector<std::string>& names);

}  // namespace glowworm
