// Glowworm's public interface. Names in glowworm::api, and glowworm::Error, stay as they are within a minor version;
// all other names that you may see in the library belong to its inside.
#pragma once
#include "glowworm/density.h"
#include "glowworm/error.h"
#include "glowworm/photons.h"
#include "glowworm/render.h"
#include "glowworm/scene.h"
#include "glowworm/types.h"

namespace glowworm::api {

/// "major.minor.patch".
const char* version();

}  // namespace glowworm::api
