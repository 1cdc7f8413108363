#include <algorithm>
#include <array>

#include "builtin/mesh_builder.h"
#include "builtin/scenes.h"
#include "builtin/sky.h"

namespace glowworm {

namespace {

void start_furnace(SceneDescription& scene, const char* name, MeshBuilder& mesh) {
  scene.name = name;
  const std::uint32_t wall = add_diffuse(scene, "wall", RGB(0.5f));
  mesh.set_material(wall, add_emission(scene, "glow", RGB(1.0f)));
  add_camera(scene, "main", {0.1f, 0.05f, -0.3f}, {-0.05f, 0, 0.4f}, 90);
  set_size(scene, 128, 128);
}

void add_floor_square(SceneDescription& scene, MeshBuilder& mesh, float half) {
  mesh.set_material(add_diffuse(scene, "floor", {0.7f, 0.68f, 0.64f}));
  mesh.quad({-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half});
}

}  // namespace

SceneDescription builtin_furnace_box() {
  SceneDescription scene;
  MeshBuilder mesh(scene.geometry);
  start_furnace(scene, "furnace-box", mesh);
  mesh.room({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f});
  return scene;
}

SceneDescription builtin_furnace_sphere() {
  SceneDescription scene;
  MeshBuilder mesh(scene.geometry);
  start_furnace(scene, "furnace-sphere", mesh);
  mesh.sphere({0, 0, 0}, 0.5f, 64, 32, true);
  // The known radiance holds for the facets' own normals.
  std::fill(scene.geometry.normals.begin(), scene.geometry.normals.end(), Vec3{0, 0, 0});
  return scene;
}

SceneDescription builtin_glass_sphere() {
  SceneDescription scene;
  scene.name = "glass-sphere";
  MeshBuilder mesh(scene.geometry);
  add_floor_square(scene, mesh, 1.5f);
  mesh.set_material(add_material(scene, clear_glass()));
  mesh.sphere({0, 0.45f, 0}, 0.3f, 128, 64);
  add_square_light(scene, mesh, {-0.7f, 2.2f, -0.4f}, {0, 0.45f, 0}, 0.12f, RGB(150));
  add_camera(scene, "main", {0.3f, 1.1f, 2.0f}, {0.1f, 0.25f, 0}, 42);
  set_size(scene, 512, 512);
  return scene;
}

SceneDescription builtin_ring() {
  SceneDescription scene;
  scene.name = "ring";
  MeshBuilder mesh(scene.geometry);
  add_floor_square(scene, mesh, 1.2f);
  Material metal;
  metal.name = "gold";
  metal.kind = MaterialKind::conductor;
  metal.use_reflectance = true;
  metal.reflectance.value = {0.9f, 0.7f, 0.35f};
  mesh.set_material(add_material(scene, metal));
  const MeshBuilder::ProfilePoint tube[] = {
      {0.5f, 0.001f, true}, {0.52f, 0.001f, true}, {0.52f, 0.22f, true}, {0.5f, 0.22f, true}, {0.5f, 0.001f, true}};
  mesh.lathe(tube, 256);
  add_square_light(scene, mesh, {1.3f, 1.2f, 0.1f}, {0, 0.1f, 0}, 0.1f, RGB(150));
  add_camera(scene, "main", {-0.3f, 1.6f, 1.4f}, {0, 0.05f, 0}, 42);
  set_size(scene, 512, 512);
  return scene;
}

SceneDescription builtin_window_room() {
  SceneDescription scene;
  scene.name = "window-room";
  MeshBuilder mesh(scene.geometry);
  const std::uint32_t wall = add_diffuse(scene, "wall", {0.65f, 0.62f, 0.57f});
  const std::uint32_t floor = add_diffuse(scene, "floor", {0.42f, 0.30f, 0.20f});
  const std::uint32_t red = add_diffuse(scene, "red block", {0.60f, 0.12f, 0.08f});
  const std::uint32_t blue = add_diffuse(scene, "blue block", {0.12f, 0.20f, 0.55f});

  // The window lies in the wall at x = 2.5; its 1 m x 0.94 m are a hundredth of the room's 94 m^2.
  const Vec3 a{-2.5f, 0, -2}, b{2.5f, 3, 2}, outside_a{-2.8f, -0.3f, -2.3f}, outside_b{2.8f, 3.3f, 2.3f};
  const float y0 = 1.2f, y1 = 2.14f, z0 = -0.5f, z1 = 0.5f;
  const auto rim = [=](float x) {
    return std::array<Vec3, 4>{Vec3{x, y0, z0}, Vec3{x, y0, z1}, Vec3{x, y1, z1}, Vec3{x, y1, z0}};
  };
  const auto in = rim(b.x), out = rim(outside_b.x);
  mesh.set_material(floor);
  mesh.quad({a.x, 0, b.z}, {b.x, 0, b.z}, {b.x, 0, a.z}, {a.x, 0, a.z});
  mesh.set_material(wall);
  mesh.quad({a.x, b.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z});
  mesh.quad({a.x, 0, b.z}, {a.x, 0, a.z}, {a.x, b.y, a.z}, {a.x, b.y, b.z});
  mesh.quad({a.x, 0, a.z}, {b.x, 0, a.z}, {b.x, b.y, a.z}, {a.x, b.y, a.z});
  mesh.quad({b.x, 0, b.z}, {a.x, 0, b.z}, {a.x, b.y, b.z}, {b.x, b.y, b.z});
  mesh.frame({{b.x, 0, a.z}, {b.x, 0, b.z}, {b.x, b.y, b.z}, {b.x, b.y, a.z}}, {in[0], in[1], in[2], in[3]});
  for (std::size_t k = 0; k < 4; ++k) mesh.quad(in[k], in[(k + 1) % 4], out[(k + 1) % 4], out[k]);
  mesh.box(outside_a, outside_b, MeshBuilder::kAllFaces & ~MeshBuilder::kMaxX);
  const float x = outside_b.x, lo = outside_a.y, hi = outside_b.y, back = outside_a.z, front = outside_b.z;
  mesh.frame({{x, lo, front}, {x, lo, back}, {x, hi, back}, {x, hi, front}}, {out[1], out[0], out[3], out[2]});

  const unsigned standing = MeshBuilder::kAllFaces & ~MeshBuilder::kMinY;
  mesh.set_transform(place({-1.2f, 0, -0.9f}, 0.4f));
  mesh.set_material(red);
  mesh.box({-0.4f, 0, -0.4f}, {0.4f, 1.4f, 0.4f}, standing);
  mesh.set_transform(place({1.3f, 0, -1.45f}, -0.3f));
  mesh.set_material(blue);
  mesh.box({-0.5f, 0, -0.3f}, {0.5f, 0.6f, 0.3f}, standing);

  const Vec3 to_sun = normalize(Vec3{0.75f, 0.62f, 0.2f});
  scene.environment = clear_sky(to_sun, 2, 64);
  scene.lights.push_back(clear_sun(to_sun));
  add_camera(scene, "main", {-0.3f, 1.6f, 1.85f}, {0.2f, 1.0f, -2}, 75);
  set_size(scene, 640, 480);
  return scene;
}

}  // namespace glowworm
