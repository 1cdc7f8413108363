// What a person asks of a scene beside its file: another environment, axis, unit or camera.
#pragma once
#include <array>
#include <optional>
#include <string>

#include "core/memory_budget.h"
#include "scene/scene.h"

namespace glowworm {

/// Changes of a scene description. As made, it changes nothing.
struct SceneChanges {
  std::string environment_file;                ///< an image; empty: the scene's own environment
  std::optional<RGB> uniform_radiance;         ///< W sr^-1 m^-2, an environment that is the same all around
  float environment_turn = 0;                  ///< degrees around the up axis, counter-clockwise seen from above
  float environment_scale = 1;                 ///< factor on the environment's radiance
  bool z_up = false;                           ///< the file's z axis points up, instead of its y axis
  float metres_per_unit = 1;                   ///< of the file's lengths
  float field_of_view = 0;                     ///< degrees along the picture's shorter side; 0: that of each camera
  std::optional<std::array<Vec3, 2>> look_at;  ///< eye and target, metres; it replaces the first camera
};

/// Reads "R,G,B" or "L" as a radiance, and anything else as the name of a file, as --environment has them. Throws Error
/// for a radiance that is negative.
void parse_environment(const std::string& text, SceneChanges& changes);

/// Reads "X,Y,Z,X,Y,Z", or "X,Y,Z;X,Y,Z", as the eye and target of --look-at. Throws Error for what is neither.
std::array<Vec3, 2> parse_look_at(const std::string& text);

/// Reads an image into an environment. A square image is an equal-area map with its middle upwards, any other a
/// lat-long map. Throws Error where the file is missing or not an image, MemoryError where the budget has no room.
Environment read_environment(const std::string& path, const std::shared_ptr<MemoryBudget>& budget);

/// Makes the changes: first the axis and the unit, then the cameras, then the environment. Adds a default camera where
/// a camera is to be changed and the scene has none. Throws Error for an environment that cannot be read.
void change_scene(SceneDescription& scene, const SceneChanges& changes, const std::shared_ptr<MemoryBudget>& budget);

}  // namespace glowworm
