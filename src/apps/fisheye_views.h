// Views that are rated for glare.
#pragma once
#include <string>
#include <vector>

#include "scene/radiance_view.h"

namespace glowworm {

/// The views of a file, as fisheyes of 180 degrees. Throws Error as parse_radiance_views() does.
std::vector<RadianceView> read_fisheyes(const std::string& path);

}  // namespace glowworm
