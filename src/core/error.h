// Error messages for the user.
#pragma once
#include <string>

#include "glowworm/error.h"

namespace glowworm {

/// "file:line:column", or as much of it as is known.
std::string to_string(const FilePlace& place);

}  // namespace glowworm
