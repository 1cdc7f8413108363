// The program's version.
#pragma once

namespace glowworm {

/// The program's version, such as "1.2.3", as CMakeLists.txt has it.
const char* version();

}  // namespace glowworm
