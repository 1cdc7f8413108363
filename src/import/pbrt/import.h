// Scenes of pbrt-v4 (and of pbrt-v3, where only names differ).
#pragma once
#include <string>

#include "core/coordinate_origin.h"
#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads a pbrt scene file with all files it includes, as pbrt-v4 defines them. Curved shapes become triangles,
/// instances are kept or expanded, and spectra become linear Rec. 709 RGB. The description's notes list unsupported
/// features (media, curves, subsurface scattering, motion, ...) with place and count; everything else is loaded. Throws
/// one Error that lists up to 20 errors, each with file:line:column and a remedy.
/// @param origin is subtracted from all positions; read_near() finds it
SceneDescription load_pbrt(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin);

}  // namespace glowworm
