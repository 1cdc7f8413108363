// Materials as the command line gives them.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/memory_budget.h"
#include "scene/scene.h"

namespace glowworm {

/// A pane of two equal faces of index `ior` around an inside that passes `transmittance` at normal incidence.
struct PaneOptics {
  double ior = 1.52, transmittance = 1;
};
/// The pane that transmits tau and reflects rho at normal incidence, with all reflections between its faces (M. Rubin,
/// "Optical properties of soda lime silica glasses", Solar Energy Materials 12, 1985). At other angles Fresnel's
/// equations hold for its faces, and it absorbs along the way inside. Values of a build-up of panes give one such pane.
/// @param tau, rho from 0 to 1, with a sum of at most 1
PaneOptics pane_of_data_sheet(double tau, double rho);
/// The same with the faces of plain glass, of index 1.52. @param tau at most what clear glass transmits, 0.918
PaneOptics pane_of_transmittance(double tau);
/// Two such panes, one behind the other, transmit tau and reflect rho, with all reflections between them.
PaneOptics half_pane_of_data_sheet(double tau, double rho);

/// Checks a text of --material. Throws Error, with the forms, for others.
void check_material_text(const std::string& text);

/// Replaces all materials of a name by a text of --material: "NAME,tau=T[,rho=R]" is a thin pane by its data sheet,
/// "NAME,bsdf=FILE" has the matrices of a file (import/window/bsdf_xml.h). Light passes two faces of a slab
/// (import/glass_sheets.h), so that each of them is half of the pane; a note counts their triangles. Throws Error as
/// check_material_text() does, for a name that no material has, and for files that cannot be read. Notes tell what was
/// changed of the matrices.
void change_material(const std::string& text, SceneDescription& scene, MemoryBudget& budget);

/// A material of the matrices in a text.
Material measured_material(std::string_view text, const std::string& path, std::vector<std::string>& notes);

}  // namespace glowworm
