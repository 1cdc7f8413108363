// Scene files to scenes: one entrance for every format.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "core/memory_budget.h"
#include "scene/scene.h"

namespace glowworm {

/// A budget for loading a scene. @param bytes 0: half of the machine's memory
std::shared_ptr<MemoryBudget> loading_budget(std::uint64_t bytes = 0);

/// What an import may use.
struct ImportOptions {
  /// Bounds what loading holds: files on their way, meshes, the scene's triangles with what rays will be traced
  /// against, and textures. A quarter of it is for texels; those beyond it go into a temporary file.
  std::shared_ptr<MemoryBudget> budget = loading_budget();
  /// Texels are read when they are first asked for, for what looks at a few of them only. Damage to the pixels of a
  /// file is not found then.
  bool lazy_textures = false;
  /// Path of the program glowworm-assimp, which reads the formats that are left to Assimp. Empty: beside the running
  /// program, or in ../libexec/glowworm from there.
  std::string assimp_program = {};
};

/// Reads a scene: "builtin:NAME", or a file by its extension: .pbrt (pbrt-v4), .gltf and .glb (glTF 2.0), .obj (with
/// its .mtl), .ply, .stl, and what Assimp reads besides (.fbx, .dae, .blend, .3ds, ...). Lengths are taken as metres
/// and the up axis as it stands. What the file asks for and is not supported is named in the description's notes; a
/// texture that cannot be read becomes magenta, with a warning and a note.
/// Throws Error with file, place and remedy for what is missing or broken or does not fit into the budget, and for
/// names and extensions that are not known.
SceneDescription load_scene(const std::string& path_or_builtin, const ImportOptions& options = {});

}  // namespace glowworm
