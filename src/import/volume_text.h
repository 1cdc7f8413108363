// Grids of smoke as the command line names them.
#pragma once
#include <string>

#include "core/memory_budget.h"
#include "scene/scene.h"

namespace glowworm {

/// Checks a text of --volume. Throws Error, with the form, for others.
void check_volume_text(const std::string& text);

/// Makes the grid "density" of a file the medium around the scene, by a text of --volume: "FILE[,scale=S][,albedo=A]".
/// The grid's places are in the axes and the unit of the scene's file. Density times S (1) is the extinction per unit;
/// A (0.5) of it scatters, evenly in all directions. A medium that is around the scene already gives way, with a note.
/// Throws Error as check_volume_text() and read_voxel_grid() do.
void add_volume(const std::string& text, SceneDescription& scene, MemoryBudget& budget);

}  // namespace glowworm
