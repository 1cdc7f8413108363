// Materials whose normal or bump maps are steep, as text.
#pragma once
#include <string>
#include <vector>

#include "scene/scene.h"

namespace glowworm {

/// One line for each material whose normal or bump map turns the normal by more than 45 degrees on more than a
/// twentieth of its surface, with that share. Shading normals lose no light here (bsdf/shaded_surface.h), so such
/// surfaces are brighter than in programs where they do. The last line summarises the rest if there are many.
std::vector<std::string> steep_map_notes(const Scene& scene);

}  // namespace glowworm
