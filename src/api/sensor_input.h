// Sensors that callers pass as arrays.
#pragma once
#include <span>

#include "glowworm/types.h"
#include "measure/sensors.h"
#include "trace/tracer.h"

namespace glowworm::api {

/// Sensors of a scene. Throws Error for arrays of different lengths or none, numbers that are not finite, normals that
/// are not unit, and, unless they lie on surfaces, sensors inside of solid objects.
Sensors sensors_of(std::span<const Vec3> position, std::span<const Vec3> normal, const glowworm::Tracer& tracer,
                   bool on_surfaces);

}  // namespace glowworm::api
