#include "builtin/builtin.h"

#include "builtin/scenes.h"
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

std::uint32_t add_diffuse(SceneDescription& scene, const char* name, RGB reflectance) {
  Material material;
  material.name = name;
  material.reflectance.value = reflectance;
  scene.materials.push_back(material);
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

std::uint32_t add_emission(SceneDescription& scene, const char* name, RGB radiance) {
  Emission emission;
  emission.name = name;
  emission.radiance.value = radiance;
  scene.emissions.push_back(emission);
  return static_cast<std::uint32_t>(scene.emissions.size() - 1);
}

}  // namespace glowworm
