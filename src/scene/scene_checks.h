// What a scene's description must keep, checked once so that nothing later needs to.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// Throws Error where a description holds an index out of range, arrays of unequal length, a vertex that is not finite,
/// textures or mixed materials that refer to themselves, or no triangle.
void check_description(const SceneDescription& description);

}  // namespace glowworm
