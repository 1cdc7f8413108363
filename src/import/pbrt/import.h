// Scenes of pbrt-v4 (and of pbrt-v3, where only names differ).
#pragma once
#include <string>

#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Reads a pbrt scene file with all that it includes. The meanings are those of pbrt-v4: see the parts of this room.
/// Curved shapes become triangles, instances are resolved, spectra become linear Rec. 709. What is not supported
/// (media, curves, subsurface scattering, motion, ...) is named with place and count in the description's notes, and
/// the rest is there.
/// Throws Error: one for all mistakes, up to 20, each as file:line:column with a remedy.
SceneDescription load_pbrt(const std::string& path, const ImportOptions& options = {});

}  // namespace glowworm
