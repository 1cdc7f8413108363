#include "scene/builtin_scenes.h"
#include "scene/mesh_builder.h"

namespace glowworm {

SceneDescription builtin_furnace_box() {
  SceneDescription scene;
  scene.name = "furnace-box";
  const std::uint32_t wall = add_diffuse(scene, "wall", RGB(0.5f));
  const std::uint32_t glow = add_emission(scene, "glow", RGB(1.0f));
  MeshBuilder mesh(scene.geometry);
  mesh.set_material(wall, glow);
  mesh.room({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f});

  Camera camera;
  camera.name = "main";
  camera.to_world = {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1f, 0.05f, -0.4f}};
  camera.half_extent = 1;
  scene.cameras.push_back(camera);
  scene.film.width = scene.film.height = 128;
  return scene;
}

}  // namespace glowworm
