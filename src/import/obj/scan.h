// A look through an OBJ file and its materials before Assimp reads them: mistakes with their line, and what is not
// supported.
#pragma once
#include <string>

#include "import/notes.h"

namespace glowworm {

/// What the scan found that the importer needs to know.
struct ObjScan {
  bool has_normals = false;           ///< the file gives vertex normals
  bool has_smoothing_groups = false;  ///< ... or says which faces are smooth
};

/// Reads an OBJ file line by line (Wavefront, "Advanced Visualizer Manual", appendix B1) and its material libraries
/// (appendix B2, "mtl"). Throws Error with file, line and remedy for a face index out of range, a face of fewer than
/// three corners, and a vertex that is no number; counts in `notes` what is not supported, material libraries that are
/// missing, and materials used but not defined.
ObjScan scan_obj(const std::string& path, NoteCounter& notes);

}  // namespace glowworm
