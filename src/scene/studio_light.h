// The light of scenes without lights.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// A neutral studio: a dim room, darker below, with a large soft key light at the upper left of the viewer and a wider,
/// weaker fill light at the right. A white diffuse surface that faces the key light has a radiance of 1 W sr^-1 m^-2.
/// @param camera the viewer
Environment studio_light(const Camera& camera);

/// Whether a scene needs the studio light: it has no light, or only decorative emission. Emission is decorative if
/// SceneDescription::emission_may_be_decoration is set, its radiance is at most 1 or comes from a texture, and the
/// scene is viewed from outside.
bool needs_studio_light(const SceneDescription& scene);

}  // namespace glowworm
