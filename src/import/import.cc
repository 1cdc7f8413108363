#include "import/import.h"

#include <fmt/format.h>

#include <filesystem>
#include <new>
#include <system_error>

#include "builtin/builtin.h"
#include "core/coordinate_origin.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/text.h"
#include "import/assimp/import.h"
#include "import/gltf/import.h"
#include "import/mesh_file.h"
#include "import/obj/reader.h"
#include "import/pbrt/import.h"
#include "import/rad/reader.h"

namespace glowworm {

namespace {

constexpr std::string_view kBuiltinPrefix = "builtin:";

void check_is_file(const std::string& path) {
  if (path.find('\0') != std::string::npos) {
    throw Error("the scene's file name holds a NUL byte", "Give the name of a file.");
  }
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw Error({path}, "no such scene file", "Check the path, or give a built-in scene such as builtin:cornell.");
  }
  if (std::filesystem::is_directory(status)) {
    throw Error({path}, "is a folder, not a scene file", "Give the scene file inside it.");
  }
  check_input_file(path);
}

SceneDescription load_format(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin) {
  const std::string extension = lower_ending(path);
  if (extension == ".pbrt") return load_pbrt(path, options, origin);
  if (extension == ".gltf" || extension == ".glb") return load_gltf(path, options, origin);
  if (extension == ".obj") return load_obj(path, options, origin);
  if (extension == ".ply") return load_ply(path, options, origin);
  if (extension == ".stl") return load_stl(path, options, origin);
  if (extension == ".rad") return load_rad(path, options, origin);
  if (assimp_reads(extension)) return load_assimp(path, options, origin);
  throw Error(
      {path}, "files of type '" + extension + "' are not supported",
      "Supported: .pbrt, .gltf, .glb, .obj, .ply, .stl, .rad and what Assimp reads (.fbx, .dae, .blend, .3ds, ...).");
}

SceneDescription load_file(const std::string& path, const ImportOptions& options) {
  check_is_file(path);
  CoordinateOrigin origin;
  SceneDescription scene = read_near(origin, [&] { return load_format(path, options, origin); });
  scene.origin = origin.origin();
  scene.origin_is_exact = !origin.is_rounded();
  return scene;
}

}  // namespace

bool has_moments(const std::string& path_or_builtin) {
  const std::string extension = lower_ending(path_or_builtin);
  return !is_builtin(path_or_builtin) && (extension == ".gltf" || extension == ".glb" || extension == ".pbrt");
}

bool is_builtin(std::string_view path_or_builtin) { return path_or_builtin.starts_with(kBuiltinPrefix); }

SceneDescription load_scene(const std::string& path_or_builtin, const ImportOptions& options) try {
  const bool moves = options.moment.seconds > 0 || !options.moment.animation.empty() || options.motion;
  if (moves && !has_moments(path_or_builtin))
    throw Error(fmt::format("'{}' has no animation: only glTF and pbrt files have", path_or_builtin),
                "Leave out --animation, --at, and --frames without --script or --turntable.");
  if (is_builtin(path_or_builtin)) return builtin_scene(path_or_builtin.substr(kBuiltinPrefix.size()));
  const InputRecord record;
  SceneDescription description = load_file(path_or_builtin, options);
  if (options.outside_files)
    for (const std::string& name : record.names())
      if (name != path_or_builtin && is_outside(name, path_or_builtin)) options.outside_files->push_back(name);
  return description;
} catch (const MemoryError& error) {
  throw Error(FilePlace{path_or_builtin}, error.what(), "", ErrorCode::memory);
} catch (const std::bad_alloc&) {
  throw Error({path_or_builtin}, "the scene does not fit into memory", "Use simpler meshes or a machine with more.",
              ErrorCode::memory);
}

}  // namespace glowworm
