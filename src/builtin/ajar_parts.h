// Furniture for the room with the door ajar. Everything stands on y = 0 of the mesh's current transform, in metres.
#pragma once
#include <cstdint>
#include <span>

#include "builtin/mesh_builder.h"

namespace glowworm::ajar {

/// A table with turned legs, 1.5 x 0.9 m and 0.76 m high.
void add_table(MeshBuilder& mesh, std::uint32_t wood);
/// A chair that faces -z.
void add_chair(MeshBuilder& mesh, std::uint32_t wood, std::uint32_t seat);
/// A case of five boards, 1.3 m wide, 1.9 m high and 0.32 m deep, its back at z = 0 and its front at z = 0.32, full of
/// books in the given colours.
void add_bookcase(MeshBuilder& mesh, std::uint32_t wood, std::span<const std::uint32_t> books);
/// A pot with lid, spout and handle, `size` metres high.
void add_teapot(MeshBuilder& mesh, float size);
void add_cup(MeshBuilder& mesh);
void add_plate(MeshBuilder& mesh);
/// A standing lamp that is not lit.
void add_floor_lamp(MeshBuilder& mesh, std::uint32_t metal, std::uint32_t shade);
/// A picture of coloured fields in a frame, in the plane z = 0 around the origin, looking towards +z.
void add_picture(MeshBuilder& mesh, std::uint32_t frame, std::span<const std::uint32_t> colors);
/// A door leaf whose hinge is the y axis and which lies along -x, 4 cm thick, with handles on both sides.
void add_door_leaf(MeshBuilder& mesh, float width, float height, std::uint32_t paint, std::uint32_t metal);

}  // namespace glowworm::ajar
