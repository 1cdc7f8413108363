// The light of a scene that brings none.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// A neutral studio: a dim room, darker below, with a large soft key light at the upper left of the viewer and a wider
/// and weaker fill at the right. A white diffuse surface that faces the key has a radiance of 1 W sr^-1 m^-2.
/// @param camera from whose side the scene is lit
Environment studio_light(const Camera& camera);

/// Whether a scene is to get the studio light: no light at all, or only emission that is decoration:
/// SceneDescription::emission_may_be_decoration says so, its radiance is at most 1 or a texture's, and the scene is
/// seen from outside.
bool needs_studio_light(const SceneDescription& scene);

}  // namespace glowworm
