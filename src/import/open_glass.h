// Panes of glass that files describe as solids.
#pragma once
#include "import/notes.h"
#include "scene/scene.h"

namespace glowworm {

/// Gives dielectric surfaces that enclose nothing, such as a window of one sheet, the material of a thin pane: as the
/// boundary of a solid without an end, they would focus light into the room behind them. A surface is all dielectric
/// triangles that share vertices, whatever their materials. It is open if its holes take more than a thousandth of its
/// area; seams where triangles meet along a line without sharing all vertices are no holes. A sheet that is modelled
/// from both sides has no holes, but no volume either. Notes count the triangles.
void make_panes_of_open_glass(SceneDescription& scene, NoteCounter& notes);

}  // namespace glowworm
