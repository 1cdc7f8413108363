#include "scene/light_groups.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/names.h"
#include "scene/light_sampling.h"

namespace glowworm {

namespace {

/// Key of a source's group: its name, or the index of its emission or light if it has none.
std::pair<std::string, std::size_t> key_of(const Scene& scene, std::uint32_t source) {
  const std::size_t triangles = scene.emissive_triangles().size(), emissions = scene.emissions().size();
  if (source < triangles) {
    const std::uint32_t emission = scene.geometry().emission[scene.emissive_triangles()[source]];
    const std::string& name = scene.emissions()[emission].name;
    return {name, name.empty() ? emission : 0};
  }
  if (source < triangles + scene.lights().size()) {
    const std::string& name = scene.lights()[source - triangles].name;
    return {name, name.empty() ? emissions + source - triangles : 0};
  }
  if (const MediumEmission* const emission = scene.medium_of_source(source)) {
    const std::string& name = scene.media()[emission->medium()].name;
    return {name, name.empty() ? emissions + source - triangles : 0};
  }
  return {scene.environment()->name, emissions + source - triangles};
}

}  // namespace

LightGroups light_groups(const Scene& scene) {
  constexpr std::size_t kMaxGroups = 100;
  LightGroups groups;
  std::map<std::pair<std::string, std::size_t>, std::uint32_t> places;
  const bool in_parts = scene.environment() && scene.environment()->parts;
  for (std::uint32_t source = 0; source < scene.light_source_count(); ++source) {
    const auto count = static_cast<std::uint32_t>(groups.names.size());
    const bool limited = !in_parts && source < scene.first_environment_source();
    const auto [place, added] =
        places.try_emplace(key_of(scene, source), limited ? std::min<std::uint32_t>(count, kMaxGroups) : count);
    groups.of_source.push_back(place->second);
    if (!added || place->second < count) continue;
    groups.names.push_back(limited && count == kMaxGroups ? "others" : light_source_name(scene, source));
  }
  number_repeated(groups.names);
  return groups;
}

}  // namespace glowworm
