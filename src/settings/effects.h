// Which effects of light a render includes or leaves out, as text.
#pragma once
#include <string>
#include <vector>

#include "scene/scene.h"
#include "settings/settings.h"

namespace glowworm {

/// One line for each material in use that makes caustics, like 'roughness 0.02 on "glass": caustics on', with the
/// reason if the settings leave them out. Roughness is the GGX alpha; the last line summarises the rest if there are
/// many materials.
std::vector<std::string> effect_notes(const Scene& scene, const RenderSettings& settings);

}  // namespace glowworm
