#include "core/version.h"

namespace glowworm {

const char* version() { return GLOWWORM_VERSION; }

}  // namespace glowworm
