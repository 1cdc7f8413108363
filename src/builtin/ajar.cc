#include <vector>

#include "builtin/ajar_parts.h"
#include "builtin/mesh_builder.h"
#include "builtin/scenes.h"

namespace glowworm {

namespace {

// The room, the corridor behind its wall towards -z, and the doorway between them.
constexpr Vec3 kRoomMin{-2.6f, 0, -2.2f}, kRoomMax{2.6f, 2.7f, 2.2f};
constexpr Vec3 kCorridorMin{-1.4f, 0, -4.4f}, kCorridorMax{3.4f, 2.7f, -2.4f};
constexpr float kDoorLeft = 0.7f, kDoorRight = 1.6f, kDoorTop = 2.05f;
constexpr float kDoorAngle = 0.6f;  // opening angle of the door, radians

struct Palette {
  std::uint32_t wall, corridor_wall, ceiling, floor, wood, dark_wood, paint, metal, shade, carpet, carpet_rim, cushion,
      porcelain, clay, glaze;
  std::vector<std::uint32_t> books;
};

Palette make_palette(SceneDescription& scene) {
  Palette p;
  p.wall = add_diffuse(scene, "wall", {0.66f, 0.62f, 0.54f});
  p.corridor_wall = add_diffuse(scene, "corridor wall", {0.74f, 0.72f, 0.68f});
  p.ceiling = add_diffuse(scene, "ceiling", {0.76f, 0.75f, 0.73f});
  p.floor = add_diffuse(scene, "floor", {0.38f, 0.25f, 0.15f});
  p.wood = add_diffuse(scene, "wood", {0.42f, 0.26f, 0.14f});
  p.dark_wood = add_diffuse(scene, "dark wood", {0.22f, 0.13f, 0.08f});
  p.paint = add_diffuse(scene, "door paint", {0.62f, 0.60f, 0.55f});
  p.metal = add_diffuse(scene, "brass", {0.45f, 0.34f, 0.16f});
  p.shade = add_diffuse(scene, "lamp shade", {0.68f, 0.60f, 0.46f});
  p.carpet = add_diffuse(scene, "carpet", {0.42f, 0.10f, 0.09f});
  p.carpet_rim = add_diffuse(scene, "carpet rim", {0.14f, 0.13f, 0.28f});
  p.cushion = add_diffuse(scene, "cushion", {0.16f, 0.32f, 0.24f});
  p.porcelain = add_diffuse(scene, "porcelain", {0.78f, 0.78f, 0.76f});
  p.clay = add_diffuse(scene, "clay", {0.50f, 0.24f, 0.14f});
  p.glaze = add_diffuse(scene, "blue glaze", {0.12f, 0.22f, 0.46f});
  const RGB books[] = {{0.42f, 0.08f, 0.07f}, {0.10f, 0.24f, 0.14f}, {0.09f, 0.14f, 0.34f}, {0.55f, 0.42f, 0.20f},
                       {0.60f, 0.56f, 0.48f}, {0.24f, 0.10f, 0.20f}, {0.16f, 0.15f, 0.14f}};
  for (const RGB& color : books) p.books.push_back(add_diffuse(scene, "book", color));
  return p;
}

// One room's shell, seen from inside. Its wall at z = door_z contains the doorway. `towards` is +1 if the room is on
// the +z side of that wall and -1 otherwise.
void add_shell(MeshBuilder& mesh, Vec3 a, Vec3 b, float towards, std::uint32_t wall, const Palette& p) {
  const float door_z = towards > 0 ? a.z : b.z, far_z = towards > 0 ? b.z : a.z;
  // Seen from inside, facing the doorway: left and right ends of the wall and of the doorway.
  const float left = towards > 0 ? a.x : b.x, right = towards > 0 ? b.x : a.x;
  const float d0 = towards > 0 ? kDoorLeft : kDoorRight, d1 = towards > 0 ? kDoorRight : kDoorLeft;
  mesh.set_material(wall);
  mesh.quad({left, 0, door_z}, {d0, 0, door_z}, {d0, kDoorTop, door_z}, {left, b.y, door_z});
  mesh.quad({d1, 0, door_z}, {right, 0, door_z}, {right, b.y, door_z}, {d1, kDoorTop, door_z});
  mesh.quad({d0, kDoorTop, door_z}, {d1, kDoorTop, door_z}, {right, b.y, door_z}, {left, b.y, door_z});
  mesh.quad({right, 0, door_z}, {right, 0, far_z}, {right, b.y, far_z}, {right, b.y, door_z});
  mesh.quad({right, 0, far_z}, {left, 0, far_z}, {left, b.y, far_z}, {right, b.y, far_z});
  mesh.quad({left, 0, far_z}, {left, 0, door_z}, {left, b.y, door_z}, {left, b.y, far_z});
  mesh.set_material(p.ceiling);
  mesh.quad({left, b.y, door_z}, {right, b.y, door_z}, {right, b.y, far_z}, {left, b.y, far_z});
  mesh.set_material(p.floor);
  const Vec3 floor[] = {{left, 0, far_z}, {right, 0, far_z}, {right, 0, door_z},
                        {d1, 0, door_z},  {d0, 0, door_z},   {left, 0, door_z}};
  mesh.polygon(floor);
}

void add_rooms(MeshBuilder& mesh, const Palette& p) {
  add_shell(mesh, kRoomMin, kRoomMax, 1, p.wall, p);
  add_shell(mesh, kCorridorMin, kCorridorMax, -1, p.corridor_wall, p);
  // The doorway through the wall: jambs, lintel and threshold.
  const float near = kRoomMin.z, far = kCorridorMax.z, l = kDoorLeft, r = kDoorRight, t = kDoorTop;
  mesh.set_material(p.paint);
  mesh.quad({l, 0, near}, {l, 0, far}, {l, t, far}, {l, t, near});
  mesh.quad({r, 0, far}, {r, 0, near}, {r, t, near}, {r, t, far});
  mesh.quad({l, t, far}, {r, t, far}, {r, t, near}, {l, t, near});
  mesh.set_material(p.floor);
  mesh.quad({l, 0, near}, {r, 0, near}, {r, 0, far}, {l, 0, far});
}

// Skirting boards of the room, and the casing around the doorway.
void add_trim(MeshBuilder& mesh, const Palette& p) {
  const Vec3 a = kRoomMin, b = kRoomMax;
  const unsigned shown = MeshBuilder::kAllFaces & ~MeshBuilder::kMinY;
  const float h = 0.1f, t = 0.015f, casing = 0.08f;
  mesh.set_material(p.paint);
  mesh.box({a.x, 0, a.z}, {kDoorLeft - casing, h, a.z + t}, shown & ~MeshBuilder::kMinZ);
  mesh.box({kDoorRight + casing, 0, a.z}, {b.x, h, a.z + t}, shown & ~MeshBuilder::kMinZ);
  mesh.box({a.x, 0, b.z - t}, {b.x, h, b.z}, shown & ~MeshBuilder::kMaxZ);
  mesh.box({a.x, 0, a.z + t}, {a.x + t, h, b.z - t}, shown & ~MeshBuilder::kMinX);
  mesh.box({b.x - t, 0, a.z + t}, {b.x, h, b.z - t}, shown & ~MeshBuilder::kMaxX);
  mesh.box({kDoorLeft - casing, 0, a.z}, {kDoorLeft, kDoorTop, a.z + 0.02f}, shown & ~MeshBuilder::kMinZ);
  mesh.box({kDoorRight, 0, a.z}, {kDoorRight + casing, kDoorTop, a.z + 0.02f}, shown & ~MeshBuilder::kMinZ);
  mesh.box({kDoorLeft - casing, kDoorTop, a.z}, {kDoorRight + casing, kDoorTop + casing, a.z + 0.02f},
           MeshBuilder::kAllFaces & ~MeshBuilder::kMinZ);
}

void add_tableware(MeshBuilder& mesh, const Palette& p, const Transform& table) {
  const auto stand = [&](float x, float z, float angle) { mesh.set_transform(table * place({x, 0.761f, z}, angle)); };
  mesh.set_material(p.porcelain);
  stand(-0.1f, 0.02f, 0.6f);
  ajar::add_teapot(mesh, 0.22f);
  mesh.set_material(p.clay);
  stand(0.36f, -0.16f, 2.4f);
  ajar::add_teapot(mesh, 0.17f);
  mesh.set_material(p.glaze);
  stand(-0.48f, -0.2f, -0.8f);
  ajar::add_teapot(mesh, 0.14f);
  mesh.set_material(p.porcelain);
  const float places[][2] = {{-0.42f, 0.26f}, {0.12f, 0.3f}, {0.52f, 0.18f}};
  for (const auto& [x, z] : places) {
    stand(x, z, 0);
    ajar::add_plate(mesh);
    mesh.set_transform(table * place({x, 0.769f, z}, 4 * x));
    ajar::add_cup(mesh);
  }
}

void furnish(MeshBuilder& mesh, const Palette& p) {
  const unsigned lying = MeshBuilder::kAllFaces & ~MeshBuilder::kMinY;
  mesh.set_material(p.carpet_rim);
  mesh.box({-1.6f, 0, -0.95f}, {1.2f, 0.008f, 1.05f}, lying);
  mesh.set_material(p.carpet);
  mesh.box({-1.42f, 0.008f, -0.77f}, {1.02f, 0.012f, 0.87f}, lying);

  const Transform table = place({-0.25f, 0.0125f, 0.05f}, 0.12f);
  mesh.set_transform(table);
  ajar::add_table(mesh, p.wood);
  add_tableware(mesh, p, table);
  const struct {
    float x, z, angle;
  } chairs[] = {{-0.35f, 0.75f, 0.2f}, {0.35f, 0.68f, -0.15f}, {-0.2f, -0.62f, 3.3f}, {-1.2f, 0.0f, -1.5f}};
  for (const auto& chair : chairs) {
    mesh.set_transform(table * place({chair.x, 0, chair.z}, chair.angle));
    ajar::add_chair(mesh, p.dark_wood, p.cushion);
  }
  mesh.set_transform(place({-1.3f, 0, kRoomMin.z + 0.02f}));
  ajar::add_bookcase(mesh, p.wood, p.books);
  mesh.set_transform(place({-2.2f, 0, -1.75f}));
  ajar::add_floor_lamp(mesh, p.metal, p.shade);
  mesh.set_transform(place({kRoomMin.x, 1.6f, -0.1f}, kPi / 2));
  ajar::add_picture(mesh, p.dark_wood, p.books);
  mesh.set_transform(place({0.1f, 1.62f, kRoomMin.z}));
  ajar::add_picture(mesh, p.wood, p.books);
  // The leaf hangs on the right jamb and opens into the room.
  mesh.set_transform(place({kDoorRight - 0.004f, 0, kRoomMin.z - 0.001f}, kDoorAngle));
  ajar::add_door_leaf(mesh, kDoorRight - kDoorLeft - 0.01f, kDoorTop - 0.008f, p.paint, p.metal);
  mesh.set_transform({});
}

// A flat lamp under the corridor's ceiling; its lower face emits.
void add_lamp(SceneDescription& scene, MeshBuilder& mesh) {
  const std::uint32_t lamp = add_diffuse(scene, "lamp", RGB(0.6f));
  const std::uint32_t light = add_emission(scene, "corridor lamp", {900, 800, 630});
  const Vec3 a{-0.5f, 2.66f, -3.7f}, b{0.5f, kCorridorMax.y, -3.3f};
  mesh.set_material(lamp);
  mesh.box(a, b, MeshBuilder::kAllFaces & ~(MeshBuilder::kMinY | MeshBuilder::kMaxY));
  mesh.set_material(lamp, light);
  mesh.box(a, b, MeshBuilder::kMinY);
}

}  // namespace

SceneDescription builtin_ajar() {
  SceneDescription scene;
  scene.name = "ajar";
  const Palette palette = make_palette(scene);
  MeshBuilder mesh(scene.geometry);
  add_rooms(mesh, palette);
  add_trim(mesh, palette);
  furnish(mesh, palette);
  add_lamp(scene, mesh);
  add_camera(scene, "main", {-2.1f, 1.55f, 2.0f}, {0.45f, 0.85f, -1.2f}, 56);
  add_camera(scene, "table", {0.9f, 1.3f, 1.5f}, {-0.4f, 0.75f, -0.2f}, 40);
  set_size(scene, 800, 600);
  return scene;
}

}  // namespace glowworm
