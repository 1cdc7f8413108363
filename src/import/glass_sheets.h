// Panes of glass that files describe as solids.
#pragma once
#include <cstdint>
#include <vector>

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

/// The triangles of slabs: panes that files describe as closed solids, by all their faces. A slab is all triangles of
/// some materials that share vertices, if they close around a volume that is at most a tenth as thick as the root of
/// the area of a side.
/// @param is_glass for each material, whether it is one of them @return indices into geometry.triangles
std::vector<std::uint32_t> triangles_of_slabs(const Geometry& geometry, const std::vector<bool>& is_glass);

}  // namespace glowworm
