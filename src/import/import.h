// Scene files to scenes: one entrance for every format.
#pragma once
#include <cstdint>
#include <string>

#include "scene/scene.h"

namespace glowworm {

/// What an import may use.
struct ImportOptions {
  /// Bytes that the texels of texture files may take in memory together; beyond it they go into a temporary file. 0
  /// means no limit.
  std::uint64_t texture_memory_bytes = 0;
  /// Path of the program glowworm-assimp, which reads the formats that are left to Assimp. Empty: beside the running
  /// program, or in ../libexec/glowworm from there.
  std::string assimp_program;
};

/// Reads a scene: "builtin:NAME", or a file by its extension: .pbrt (pbrt-v4), .gltf and .glb (glTF 2.0), .obj (with
/// its .mtl), .ply, .stl, and what Assimp reads besides (.fbx, .dae, .blend, .3ds, ...). Lengths are taken as metres
/// and the up axis as it stands. What the file asks for and is not supported is named in the description's notes; a
/// texture that cannot be read becomes magenta, with a warning and a note.
/// Throws Error with file, place and remedy for what is missing or broken, and for names and extensions that are not
/// known.
SceneDescription load_scene(const std::string& path_or_builtin, const ImportOptions& options = {});

}  // namespace glowworm
