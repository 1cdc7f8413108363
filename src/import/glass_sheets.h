// Panes of glass that files describe as solids.
#pragma once
#include "import/notes.h"
#include "scene/scene.h"

namespace glowworm {

/// Gives flat sheets of a dielectric, such as a window of one sheet, the material of a thin pane: as the boundary of a
/// solid without an end, they would focus light into the room behind them. A sheet is all dielectric triangles that
/// share vertices, whatever their materials, if they lie in a plane, or if they enclose no volume as where a sheet is
/// modelled from both sides. An uneven sheet may be the surface of a liquid, whose body other surfaces close, and
/// stays. Notes count the triangles.
void make_panes_of_glass_sheets(SceneDescription& scene, NoteCounter& notes);

}  // namespace glowworm
