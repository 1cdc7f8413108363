// Loads scene files of all formats.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/memory_budget.h"
#include "core/shutter.h"
#include "scene/scene.h"

namespace glowworm {

struct GltfParts;
class GltfReader;
class TextureLibrary;

/// A memory budget for loading a scene. @param bytes 0: half of the machine's memory
std::shared_ptr<MemoryBudget> loading_budget(std::uint64_t bytes = 0);

/// Textures for imports of one file at several moments, which then read each texture once.
std::shared_ptr<TextureLibrary> texture_library(const std::shared_ptr<MemoryBudget>& budget);

/// What is read of a glTF file, for imports of one file at several moments, which then read it once.
std::shared_ptr<GltfReader> gltf_reader();

/// A moment of a scene that moves.
struct Moment {
  std::string animation;  ///< name in the file, or number from 0; empty: the first, if there is one
  double seconds = 0;     ///< of that animation
};

/// A moment of a frame: its own, or the moment of a slice of the time for which the shutter is open.
struct FrameMoment {
  std::uint32_t frame = 0, slice = 0;  ///< slice 0: the frame's own moment; others are counted from 1

  /// The name of a camera of this moment.
  std::string camera() const {
    return "frame " + std::to_string(frame) + (slice > 0 ? " slice " + std::to_string(slice) : "");
  }
};

/// A camera at all frames of an animation, and what else moves in it.
struct SceneMotion {
  std::string camera;                ///< name; empty: the file's first
  double start = 0;                  ///< moment of frame 0, s
  double frames_per_second = 24;     ///< frame i is the moment start + i / frames_per_second
  std::uint32_t frames = 0;          ///< the fewest; the import raises it to the whole animation
  bool is_still = false;             ///< there is no other frame than the first
  std::optional<Shutter> shutter;    ///< empty: the import sets what the file asks for, if anything
  std::uint32_t slices = 1;          ///< of the time of the shutter
  std::uint32_t seed = 0;            ///< of the moments of slices
  bool anything_else_moves = false;  ///< set by the import: whether meshes or lights differ between moments
  double length = 0;                 ///< set by the import: seconds of the whole animation; 0: there is none

  /// Slices of each frame; 0: its moment alone is shown.
  std::uint32_t slice_count() const { return shutter && shutter->close > shutter->open ? slices : 0; }
  /// Raises the frames to the whole animation, unless it is a still.
  void cover_length();
  /// Seconds of a moment.
  double seconds(FrameMoment moment) const;
  /// All moments: of each frame its own, then its slices.
  std::vector<FrameMoment> moments() const;
};

/// Resources and options of an import.
struct ImportOptions {
  /// Limits the memory of loading: file contents, meshes, the scene's triangles with their ray-tracing structures, and
  /// textures. A quarter is for texels; further texels go into a temporary file.
  std::shared_ptr<MemoryBudget> budget = loading_budget();
  /// Reads texels on first use. Use it if only a few are needed. Damaged pixels of a file are then not detected while
  /// loading.
  bool lazy_textures = false;
  /// Reads TEXCOORD_1 of glTF files as second texture coordinates where no texture needs another set.
  bool light_uvs = false;
  /// Gets the origin of the triangles of a glTF file, unless it is null.
  std::shared_ptr<GltfParts> gltf_parts = {};
  /// The moment that is shown, of a glTF or pbrt file.
  Moment moment = {};
  /// Gets the cameras of more moments of a glTF or pbrt file, after its own; null: none.
  std::shared_ptr<SceneMotion> motion = {};
  /// Gets the files outside of the scene file's folder that were read, unless it is null.
  std::shared_ptr<std::vector<std::string>> outside_files = {};
  /// Path of the program glowworm-assimp, which reads the formats left to Assimp. Empty: look beside the running
  /// program, or in ../libexec/glowworm relative to it.
  std::string assimp_program = {};
  /// Textures of earlier imports with the same budget; null: none.
  std::shared_ptr<TextureLibrary> textures = {};
  /// What earlier imports with the same budget have read of the same glTF file; null: none.
  std::shared_ptr<GltfReader> gltf = {};
};

/// Whether the name means a built-in scene, "builtin:NAME", known or not.
bool is_builtin(std::string_view path_or_builtin);

/// Whether the file's format has animations that the import reads.
bool has_moments(const std::string& path_or_builtin);

/// Reads a scene: "builtin:NAME", or a file by its extension: .pbrt (pbrt-v4), .gltf and .glb (glTF 2.0), .obj (with
/// its .mtl), .ply, .stl, .rad (Radiance), or another format that Assimp reads (.fbx, .dae, .blend, .3ds, ...). Lengths
/// are interpreted as metres; the up axis is not changed, except in .rad files, whose z becomes y. The description's
/// notes list features of the file that are not supported. A texture that cannot be read becomes its stand-in
/// (import/stand_in.h), with a warning and a note. Throws Error with file, place and remedy if something is missing,
/// broken or too large for the budget, or if the name or the extension is unknown.
SceneDescription load_scene(const std::string& path_or_builtin, const ImportOptions& options = {});

}  // namespace glowworm
