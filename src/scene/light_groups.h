// Light sources by name: what one layer of light shows.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace glowworm {

/// Groups of light sources, in the order of the scene. Sources of one name are a group; a light without a name is one
/// of its own, named by its kind and a number.
struct LightGroups {
  std::vector<std::string> names;        ///< "lamp", "area light 1", "area light 2"
  std::vector<std::uint32_t> of_source;  ///< index into `names` of each source, counted as in Scene::light_power()
};

/// Groups the scene's light sources. A scene with more than a hundred groups puts the rest into one more, "others",
/// unless its environment has parts, each of which is a group.
LightGroups light_groups(const Scene& scene);

}  // namespace glowworm
