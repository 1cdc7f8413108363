// Copies of what a .rad file describes: the options of xform.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/transform_double.h"

namespace glowworm {

/// Where and how the primitives of a file are placed.
struct RadPlacement {
  TransformDouble to_world;
  bool inverted = false;  ///< surfaces face the other way
  std::string prefix;     ///< of the names of surfaces, with its dot; xform -n
  std::string modifier;   ///< of all surfaces, in place of their own; empty: their own
};

/// What is placed by `inner`, then by `outer`.
RadPlacement operator*(const RadPlacement& outer, const RadPlacement& inner);

/// Calls visit(placement, files) for each copy that a command of xform describes: -n, -m, -I, -t, -rx, -ry, -rz, -s,
/// -mx, -my, -mz, -i, arrays by -a, and lines of a file of arguments by -f. Throws Error for other options.
/// @param words of the command, without "xform"
/// @param read_file the text of a file of arguments
/// @param count     called for each step of the work, which may throw where there are too many
void for_each_rad_copy(
    const std::vector<std::string>& words, const FilePlace& place,
    const std::function<std::string(const std::string& name)>& read_file, const std::function<void()>& count,
    const std::function<void(const RadPlacement& placement, const std::vector<std::string>& files)>& visit);

/// The polygons, cylinders and spheres of a box as genbox(1) describes them, as a text. Throws Error as genbox does.
/// @param words of the command, without "genbox"
std::string rad_box(const std::vector<std::string>& words, const FilePlace& place);

}  // namespace glowworm
