// Surfaces of Radiance's scene files as triangles.
#pragma once
#include <string>

#include "core/coordinate_origin.h"
#include "import/notes.h"
#include "import/rad/placement.h"
#include "import/rad/words.h"
#include "scene/geometry.h"

namespace glowworm {

/// Whether a type of primitive is a surface with a shape: all but sources, instances and meshes.
bool is_rad_surface(const std::string& type);

/// The triangles of a polygon, sphere, bubble, cone, cup, cylinder, tube or ring, in world space, wound
/// counter-clockwise seen from where it faces. Round ones have the area of the true surface, and its normals. A polygon
/// may have holes, joined to its border by seams. Throws Error with file and line for wrong arguments.
/// @param origin is subtracted from all positions
/// @param to_world as the file's `placement`, with z up made y up
Geometry rad_surface(const RadPrimitive& p, const TransformDouble& to_world, bool inverted, CoordinateOrigin& origin,
                     NoteCounter& notes);

}  // namespace glowworm
