// Makes a scene of arrays (a floor, a red wall and a lamp) and renders it.
#include <glowworm/glowworm.h>

#include <array>
#include <iostream>

namespace gw = glowworm::api;

namespace {

/// A parallelogram at `corner` with the sides a and b. Its front is where a and b turn counter-clockwise.
void add_parallelogram(gw::SceneBuilder& scene, gw::Vec3 corner, gw::Vec3 a, gw::Vec3 b, std::uint32_t material,
                       gw::Rgb radiance = {}) {
  const auto plus = [](gw::Vec3 u, gw::Vec3 v) { return gw::Vec3{u.x + v.x, u.y + v.y, u.z + v.z}; };
  const std::array<gw::Vec3, 4> positions{corner, plus(corner, a), plus(plus(corner, a), b), plus(corner, b)};
  const std::array<gw::Triangle, 2> triangles{gw::Triangle{0, 1, 2}, gw::Triangle{0, 2, 3}};
  gw::Mesh mesh;
  mesh.positions = positions;
  mesh.triangles = triangles;
  mesh.material = material;
  mesh.radiance = radiance;
  scene.add_mesh(mesh);
}

}  // namespace

int main() {
  gw::SceneBuilder builder("arrays");
  gw::Material white, red;
  white.color = {0.8f, 0.8f, 0.8f};
  red.color = {0.7f, 0.1f, 0.1f};
  const std::uint32_t paint = builder.add_material(white), brick = builder.add_material(red);
  add_parallelogram(builder, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, paint);
  add_parallelogram(builder, {-1, 0, -1}, {2, 0, 0}, {0, 2, 0}, brick);
  add_parallelogram(builder, {-0.3f, 2, 0.3f}, {0, 0, -0.6f}, {0.6f, 0, 0}, paint, {10, 10, 10});
  gw::Camera camera;
  camera.eye = {0, 1, 4};
  camera.target = {0, 0.8f, 0};
  builder.add_camera(camera);
  const gw::Scene scene = builder.build();
  gw::RenderOptions options;
  options.width = options.height = 128;
  options.samples = 4;
  gw::write_picture("arrays.png", gw::render(scene, options));
  std::cout << scene.triangle_count() << " triangles rendered to arrays.png\n";
}
