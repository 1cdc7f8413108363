#include "builtin/builtin.h"

#include "builtin/mesh_builder.h"
#include "builtin/scenes.h"
#include "core/frame.h"
#include "core/names.h"

namespace glowworm {

namespace {

struct Entry {
  const char* name;
  SceneDescription (*make)();
};

constexpr Entry kScenes[] = {
    {"cornell", builtin_cornell},
    {"atrium", builtin_atrium},
    {"ajar", builtin_ajar},
    {"furnace-box", builtin_furnace_box},
    {"furnace-sphere", builtin_furnace_sphere},
    {"glass-sphere", builtin_glass_sphere},
    {"ring", builtin_ring},
    {"window-room", builtin_window_room},
    {"shafts", builtin_shafts},
    {"glass-in-gas", builtin_glass_in_gas},
    {"atrium-large", builtin_atrium_large},
};

}  // namespace

std::vector<std::string> builtin_scene_names() {
  std::vector<std::string> names;
  for (const Entry& entry : kScenes) names.push_back(entry.name);
  return names;
}

SceneDescription builtin_scene(const std::string& name) {
  return kScenes[name_index("the built-in scene", name, builtin_scene_names())].make();
}

std::uint32_t add_material(SceneDescription& scene, const Material& material) {
  scene.materials.push_back(material);
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

Material clear_glass() {
  Material glass;
  glass.name = "glass";
  glass.kind = MaterialKind::dielectric;
  glass.ior = 1.5f;
  glass.reflectance.value = glass.transmittance.value = RGB(1.0f);
  return glass;
}

std::uint32_t add_diffuse(SceneDescription& scene, const char* name, RGB reflectance) {
  Material material;
  material.name = name;
  material.reflectance.value = reflectance;
  return add_material(scene, material);
}

std::uint32_t add_emission(SceneDescription& scene, const char* name, RGB radiance) {
  Emission emission;
  emission.name = name;
  emission.radiance.value = radiance;
  scene.emissions.push_back(emission);
  return static_cast<std::uint32_t>(scene.emissions.size() - 1);
}

void add_square_light(SceneDescription& scene, MeshBuilder& mesh, Vec3 center, Vec3 target, float side, RGB radiance) {
  const std::uint32_t lamp = add_diffuse(scene, "lamp", RGB(0.5f));
  mesh.set_material(lamp, add_emission(scene, "lamp", radiance));
  const Frame frame = Frame::from_normal(normalize(target - center));
  const Vec3 s = frame.s * (side / 2), t = frame.t * (side / 2);
  mesh.quad(center - s - t, center + s - t, center + s + t, center - s + t);
}

void add_camera(SceneDescription& scene, const char* name, Vec3 eye, Vec3 target, float degrees) {
  scene.cameras.push_back(look_at(eye, target, {0, 1, 0}, degrees));
  scene.cameras.back().name = name;
}

void set_size(SceneDescription& scene, int width, int height) {
  scene.film.width = width;
  scene.film.height = height;
}

}  // namespace glowworm
