// Changes of a loaded scene on request: environment, up axis, unit or camera.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/memory_budget.h"
#include "import/import.h"
#include "scene/scene.h"

namespace glowworm {

/// Changes of a scene description. The default changes nothing.
struct SceneChanges {
  std::string environment_file;         ///< an image; empty: the scene's own environment
  std::optional<RGB> uniform_radiance;  ///< W sr^-1 m^-2, an environment of constant radiance
  std::string sky;                      ///< replaces the environment, as add_sky() parses it
  float environment_turn = 0;           ///< degrees around the up axis, counter-clockwise seen from above
  float environment_scale = 1;          ///< factor on the environment's radiance
  /// Whether the file's z axis points up, or else its y axis; empty: as its format has it. The places and directions of
  /// luminaires, views and look_at have it.
  std::optional<bool> z_up;
  float metres_per_unit = 1;                    ///< scale of the file's lengths
  Moment moment;                                ///< of a file that moves; open_scene() reads the file with it
  bool expand_instances = false;                ///< into copies of their meshes
  bool studio_light = true;                     ///< where the scene has no light
  float field_of_view = 0;                      ///< degrees along the picture's shorter side; 0: each camera's own
  std::optional<CameraKind> projection;         ///< of all cameras; angular ones show 180 degrees by default
  std::string volume;                           ///< a grid of smoke, as add_volume() parses it; empty: none
  float visibility = 0;                         ///< metres, in haze around the scene; 0: no haze
  std::vector<std::string> luminaires;          ///< more lights, as luminaire_of_text() reads them
  std::vector<std::string> materials;           ///< replacements, as change_material() reads them
  std::string view_file;                        ///< of Radiance; its cameras stand before the scene's
  bool luminous_openings = true;                ///< luminaires have the size that their files say; else they are points
  std::optional<std::array<Vec3d, 2>> look_at;  ///< eye and target, metres; it replaces the first camera
};

/// Parses a value of --environment: "R,G,B" or "L" is a radiance; anything else is a file name. Throws Error for a
/// radiance that is negative or not finite.
void parse_environment(const std::string& text, SceneChanges& changes);

/// Parses a value of --look-at: eye and target as "X,Y,Z,X,Y,Z" or "X,Y,Z;X,Y,Z". Throws Error for anything else.
std::array<Vec3d, 2> parse_look_at(const std::string& text);

/// An option that changes a scene, on the command line and in other languages.
struct SceneOption {
  const char *name, *values, *meaning;  ///< "--up", "y|z [y]"; for the help
  /// Parses the text. Throws Error that names the option.
  void (*read)(SceneChanges&, const std::string& text);
  bool repeats = false;  ///< each of several counts, not the last alone
};
/// All of them, in the order of the help.
std::span<const SceneOption> scene_options();

/// Reads an image as an environment. A square image is an equal-area map with its centre upwards; any other is a
/// lat-long map. Throws Error if the file is missing or not an image, and MemoryError if it exceeds the budget.
Environment read_environment(const std::string& path, const std::shared_ptr<MemoryBudget>& budget);

/// Applies the changes: first the axis and the unit, then the cameras, luminaires, haze and environment. Adds a default
/// camera if a camera change is requested and the scene has none. Throws Error if a file cannot be read.
void change_scene(SceneDescription& scene, const SceneChanges& changes, const std::shared_ptr<MemoryBudget>& budget);

}  // namespace glowworm
