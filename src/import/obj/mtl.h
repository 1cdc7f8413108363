// Material libraries of OBJ files.
#pragma once
#include <string_view>
#include <vector>

#include "import/notes.h"
#include "import/phong.h"

namespace glowworm {

/// Reads an MTL file (Wavefront, "Advanced Visualizer Manual", appendix B2; Pr, Pm and norm of its later extension).
/// Notes count unsupported features and invalid numbers. A name defined twice gives two materials.
std::vector<PhongMaterial> parse_mtl(std::string_view text, NoteCounter& notes);

}  // namespace glowworm
