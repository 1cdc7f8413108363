#include "builtin/mesh_builder.h"
#include "builtin/scenes.h"

namespace glowworm {

namespace {

// Source: Cornell University Program of Computer Graphics, "Cornell Box Data",
// https://www.graphics.cornell.edu/online/box/data.html. The RGB reflectances give light of the lamp, reflected once,
// exactly the colour of the measured spectra (tests/builtin/spectra.h, whose test compares them).
constexpr RGB kWhite{0.738595486f, 0.735403061f, 0.750717759f};
constexpr RGB kGreen{0.118561327f, 0.381829917f, 0.023513047f};
constexpr RGB kRed{0.448860288f, 0.0391712077f, 0.0102728242f};
constexpr RGB kLamp{20.6240044f, 10.9080219f, 2.76196551f};  ///< W sr^-1 m^-2

// The source gives millimetres.
Vec3 mm(float x, float y, float z) { return {x / 1000, y / 1000, z / 1000}; }

// The ceiling around the lamp's opening, cut out so that no faces coincide.
void add_ceiling(MeshBuilder& mesh) {
  const Vec3 outer[4] = {mm(556, 548.8f, 0), mm(556, 548.8f, 559.2f), mm(0, 548.8f, 559.2f), mm(0, 548.8f, 0)};
  const Vec3 inner[4] = {mm(343, 548.8f, 227), mm(343, 548.8f, 332), mm(213, 548.8f, 332), mm(213, 548.8f, 227)};
  mesh.frame(outer, inner);
}

// A block without its underside, which stands on the floor. `top` runs counter-clockwise seen from above.
void add_block(MeshBuilder& mesh, const Vec3 (&top)[4]) {
  mesh.polygon(top);
  for (int k = 0; k < 4; ++k) {
    const Vec3 a = top[k], b = top[(k + 1) % 4];
    mesh.quad({a.x, 0, a.z}, {b.x, 0, b.z}, b, a);
  }
}

}  // namespace

SceneDescription builtin_cornell() {
  SceneDescription scene;
  scene.name = "cornell";
  const std::uint32_t white = add_diffuse(scene, "white", kWhite);
  const std::uint32_t green = add_diffuse(scene, "green", kGreen);
  const std::uint32_t red = add_diffuse(scene, "red", kRed);
  // The source gives the lamp's own reflectance as 0.78.
  const std::uint32_t lamp = add_diffuse(scene, "lamp", RGB(0.78f));
  const std::uint32_t light = add_emission(scene, "lamp", kLamp);

  MeshBuilder mesh(scene.geometry);
  mesh.set_material(white);
  scene.geometry.begin_object("floor");
  mesh.quad(mm(552.8f, 0, 0), mm(0, 0, 0), mm(0, 0, 559.2f), mm(549.6f, 0, 559.2f));
  scene.geometry.begin_object("ceiling");
  add_ceiling(mesh);
  scene.geometry.begin_object("back wall");
  mesh.quad(mm(549.6f, 0, 559.2f), mm(0, 0, 559.2f), mm(0, 548.8f, 559.2f), mm(556, 548.8f, 559.2f));
  scene.geometry.begin_object("right wall");
  mesh.set_material(green);
  mesh.quad(mm(0, 0, 559.2f), mm(0, 0, 0), mm(0, 548.8f, 0), mm(0, 548.8f, 559.2f));
  scene.geometry.begin_object("left wall");
  mesh.set_material(red);
  mesh.quad(mm(552.8f, 0, 0), mm(549.6f, 0, 559.2f), mm(556, 548.8f, 559.2f), mm(556, 548.8f, 0));
  scene.geometry.begin_object("lamp");
  mesh.set_material(lamp, light);
  mesh.quad(mm(343, 548.8f, 227), mm(343, 548.8f, 332), mm(213, 548.8f, 332), mm(213, 548.8f, 227));
  mesh.set_material(white);
  scene.geometry.begin_object("short block");
  add_block(mesh, {mm(130, 165, 65), mm(82, 165, 225), mm(240, 165, 272), mm(290, 165, 114)});
  scene.geometry.begin_object("tall block");
  add_block(mesh, {mm(423, 330, 247), mm(265, 330, 296), mm(314, 330, 456), mm(472, 330, 406)});

  Camera camera;
  camera.name = "main";
  camera.to_world = {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, mm(278, 273, -800)};
  camera.half_extent = 0.5f * 25 / 35;  // film of 25 x 25 mm behind a lens of 35 mm
  scene.cameras.push_back(camera);
  set_size(scene, 512, 512);
  return scene;
}

}  // namespace glowworm
