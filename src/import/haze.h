// Haze around a scene.
#pragma once
#include <string>

#include "scene/scene.h"

namespace glowworm {

/// Parses a length, such as "200", "200m" or "2km", into metres. Throws Error that names the option for anything else,
/// and for lengths that are not positive.
float length_of_text(const char* option, const std::string& text);

/// Makes haze the medium around the scene, in a box around its surfaces, cameras and lamps. In front of the haze over
/// the visibility, contrast falls to 2%: sigma_t = 3.912 / visibility (Koschmieder 1924). A medium that is around the
/// scene already gives way, with a note. @param visibility metres
void add_haze(SceneDescription& scene, float visibility);

}  // namespace glowworm
