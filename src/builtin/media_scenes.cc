#include "builtin/mesh_builder.h"
#include "builtin/scenes.h"
#include "builtin/sky.h"

namespace glowworm {

namespace {

/// Fills a box of the scene's space with a medium.
void fill(SceneDescription& scene, const char* name, float sigma_s, float sigma_a, float g, Vec3 min, Vec3 max) {
  Medium medium;
  medium.name = name;
  medium.sigma_s = RGB(sigma_s);
  medium.sigma_a = RGB(sigma_a);
  medium.g = g;
  medium.bounds = Box3{min, max};
  scene.ambient_medium = static_cast<std::uint32_t>(scene.media.size());
  scene.media.push_back(std::move(medium));
}

}  // namespace

SceneDescription builtin_shafts() {
  SceneDescription scene;
  scene.name = "shafts";
  MeshBuilder mesh(scene.geometry);
  const std::uint32_t wall = add_diffuse(scene, "wall", {0.45f, 0.43f, 0.40f});
  const std::uint32_t floor = add_diffuse(scene, "floor", {0.35f, 0.24f, 0.16f});
  const std::uint32_t wood = add_diffuse(scene, "slats", {0.30f, 0.18f, 0.10f});
  const std::uint32_t cloth = add_diffuse(scene, "chest", {0.45f, 0.10f, 0.08f});
  // A room of 4 x 2.8 x 5 m with walls of 0.2 m. The window is in the wall at x = 2.
  constexpr float kWall = 0.2f, kX = 2, kY = 2.8f, kZ = 2.5f, kBottom = 0.9f, kTop = 2.3f, kSide = 0.9f;
  mesh.set_material(floor);
  mesh.box({-kX - kWall, -kWall, -kZ - kWall}, {kX + kWall, 0, kZ + kWall});
  mesh.set_material(wall);
  mesh.box({-kX - kWall, kY, -kZ - kWall}, {kX + kWall, kY + kWall, kZ + kWall});
  mesh.box({-kX - kWall, 0, -kZ - kWall}, {-kX, kY, kZ + kWall});
  mesh.box({-kX, 0, -kZ - kWall}, {kX, kY, -kZ});
  mesh.box({-kX, 0, kZ}, {kX, kY, kZ + kWall});
  mesh.box({kX, 0, -kZ - kWall}, {kX + kWall, kY, -kSide});
  mesh.box({kX, 0, kSide}, {kX + kWall, kY, kZ + kWall});
  mesh.box({kX, 0, -kSide}, {kX + kWall, kBottom, kSide});
  mesh.box({kX, kTop, -kSide}, {kX + kWall, kY, kSide});
  mesh.set_material(wood);
  constexpr int kSlats = 6;
  constexpr float kPitch = (kTop - kBottom) / kSlats, kThick = 0.1f;
  for (int i = 0; i < kSlats; ++i) {
    const float y = kBottom + kPitch * (static_cast<float>(i) + 0.5f) - kThick / 2;
    mesh.box({kX + 0.05f, y, -kSide}, {kX + 0.15f, y + kThick, kSide});
  }
  mesh.set_material(cloth);
  mesh.set_transform(place({-0.5f, 0, -0.6f}, 0.4f));
  mesh.box({-0.5f, 0, -0.35f}, {0.5f, 0.6f, 0.35f}, MeshBuilder::kAllFaces & ~MeshBuilder::kMinY);
  scene.lights.push_back(clear_sun(normalize(Vec3{0.75f, 0.55f, 0.15f})));
  fill(scene, "haze", 0.05f, 0.002f, 0.5f, {-kX, 0, -kZ}, {kX, kY, kZ});
  add_camera(scene, "main", {-1.2f, 1.5f, 2.3f}, {0.6f, 1.15f, -0.6f}, 62);
  set_size(scene, 640, 480);
  return scene;
}

SceneDescription builtin_glass_in_gas() {
  SceneDescription scene;
  scene.name = "glass-in-gas";
  MeshBuilder mesh(scene.geometry);
  fill(scene, "gas", 0.15f, 0.01f, 0, {-1.5f, 0, -1.5f}, {1.5f, 2.3f, 1.5f});
  mesh.set_material(add_diffuse(scene, "floor", {0.35f, 0.34f, 0.32f}));
  mesh.quad({-1.5f, 0, 1.5f}, {1.5f, 0, 1.5f}, {1.5f, 0, -1.5f}, {-1.5f, 0, -1.5f});
  Material glass = clear_glass();
  glass.inside = kNone;
  glass.outside = scene.ambient_medium;
  mesh.set_material(add_material(scene, glass));
  const Vec3 ball{0, 0.85f, 0}, lamp{-0.75f, 2.25f, -0.2f};
  mesh.sphere(ball, 0.3f, 128, 64);
  add_square_light(scene, mesh, lamp, ball, 0.08f, RGB(300));
  add_camera(scene, "main", {0.2f, 1.0f, 2.6f}, {0.1f, 0.75f, 0}, 44);
  set_size(scene, 512, 512);
  return scene;
}

}  // namespace glowworm
