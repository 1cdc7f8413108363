// A default view of a scene without cameras.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// Where a scene is looked at from.
enum class SceneShape : std::uint8_t {
  object,  ///< from outside and a little above, so that its vertices fill the picture
  panel,   ///< flat: straight at its front
  box,     ///< open to one side, and its other walls face the middle: straight into the opening
  room,    ///< walls stand all around, or hide most triangles from outside: from within
};
SceneShape shape_of(const Geometry& geometry);

/// Adds a camera that sees the scene, and a note, where there is none. In a room it stands where most of the room is
/// seen at a distance, of a grid of places and directions.
/// @param field_of_view degrees along the picture's shorter side; 0: 45, and more in rooms
void add_default_camera(SceneDescription& scene, float field_of_view = 0);

}  // namespace glowworm
