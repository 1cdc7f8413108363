// Panes of glass that files describe as solids.
#pragma once
#include "import/notes.h"
#include "scene/scene.h"

namespace glowworm {

/// Gives sheets of a dielectric, such as a window or a bottle of one sheet, the material of a thin pane: as the
/// boundary of a solid without an end, they would focus light behind them. A sheet is all dielectric triangles that
/// share vertices, whatever their materials, if they
/// - lie in a plane, or
/// - enclose no volume, as where a sheet is modelled from both sides, or
/// - have a free border: edges of one triangle to which nothing is near, longer than a tenth of the root of their area.
///   What is shorter is a hole in a solid. The surface of a liquid has no free border: a vessel closes its body.
/// Notes count the triangles.
void make_panes_of_glass_sheets(SceneDescription& scene, NoteCounter& notes);

}  // namespace glowworm
