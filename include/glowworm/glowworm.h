// Glowworm's public interface. Names in glowworm::api are stable within a minor version. All other names in the library
// are private.
#pragma once
#include "glowworm/bake.h"
#include "glowworm/daylight.h"
#include "glowworm/density.h"
#include "glowworm/error.h"
#include "glowworm/interrupt.h"
#include "glowworm/photons.h"
#include "glowworm/picture.h"
#include "glowworm/rays.h"
#include "glowworm/render.h"
#include "glowworm/scene.h"
#include "glowworm/sensors.h"
#include "glowworm/statistics.h"
#include "glowworm/types.h"

namespace glowworm::api {

/// "major.minor.patch".
const char* version();

}  // namespace glowworm::api
