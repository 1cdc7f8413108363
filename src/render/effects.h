// Which effects of light a render shows or leaves out, in words.
#pragma once
#include <string>
#include <vector>

#include "render/settings.h"
#include "scene/scene.h"

namespace glowworm {

/// One line for each material in use that makes caustics, like 'roughness 0.02 on "glass": caustics on', and why they
/// are off where the settings leave them out. Roughness is the GGX alpha; many materials are summed up in the last
/// line.
std::vector<std::string> effect_notes(const Scene& scene, const RenderSettings& settings);

}  // namespace glowworm
