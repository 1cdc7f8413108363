// A default view of a scene without cameras.
#pragma once
#include "scene/scene.h"

namespace glowworm {

/// The viewpoint chosen for a scene.
enum class SceneShape : std::uint8_t {
  object,  ///< from outside and slightly above, so that its vertices fill the picture
  panel,   ///< flat: straight at its front
  box,     ///< open to one side, with its other walls facing inwards: straight into the opening
  room,    ///< walls on all sides, or hiding most triangles from outside: from inside
};
SceneShape shape_of(const Geometry& geometry);

/// Adds a camera that sees the scene, and a note, if there is no camera. In a room, it chooses the position and
/// direction of a grid that see most of the room at a distance.
/// @param field_of_view degrees along the picture's shorter side; 0: 45, and more in rooms
void add_default_camera(SceneDescription& scene, float field_of_view = 0);

}  // namespace glowworm
