// Luminous openings of luminaires: as photometric files write them, and as triangles.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// The opening that an IES LM-63 file means by its width (across the plane C0 to C180), length (along it) and height
/// (metres, with their signs). A negative size means a round shape; editions before 2002 write one for both sizes
/// of a circle or an ellipse, and 0 for the other.
/// @param edition the year
LuminousOpening lm63_opening(float width, float length, float height, int edition);

/// Replaces each luminaire that has an opening by the triangles of that, which emit what its table says and let all
/// light pass. Notes openings that have only one size; such luminaires stay points.
void add_luminous_openings(SceneDescription& scene);

}  // namespace glowworm
